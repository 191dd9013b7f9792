// One stream of events for all pages of a browser, which allows few connections to one host. Runs as a SharedWorker.
const types = ['state', 'document', 'run', 'variants', 'node', 'progress', 'arrangement'];
const pages = new Map(); // port: the events that wait until it has the state, or null
let source = null;

function tell(message) {
  for (const [port, waiting] of pages) waiting ? waiting.push(message) : port.postMessage(message);
}

function open() {
  source = new EventSource('/api/events');
  source.onopen = () => tell({ kind: 'open' });
  source.onerror = () => tell({ kind: 'error', closed: source.readyState === EventSource.CLOSED });
  for (const kind of types) source.addEventListener(kind, e => tell({ kind, number: Number(e.lastEventId), data: e.data }));
}

// A page that joins gets the whole state, and then what happened since.
async function join(port) {
  const waiting = [];
  pages.set(port, waiting);
  try {
    const answer = await fetch('/api/state');
    if (!answer.ok) throw new Error(String(answer.status));
    const data = await answer.text(), number = JSON.parse(data).number;
    port.postMessage({ kind: 'open' });
    port.postMessage({ kind: 'state', number, data });
    for (const m of waiting) if (!(m.number <= number)) port.postMessage(m);
  } catch {
    port.postMessage({ kind: 'error', closed: source.readyState === EventSource.CLOSED });
    for (const m of waiting) port.postMessage(m);
  }
  if (pages.has(port)) pages.set(port, null);
}

onconnect = e => {
  const port = e.ports[0];
  port.onmessage = () => pages.delete(port); // the page is leaving
  if (!source || source.readyState === EventSource.CLOSED) open();
  void join(port);
};
