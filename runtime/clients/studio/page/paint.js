// The page of `terrazzo paint`: shows the image, sends strokes and shows their results. All painting happens on the
// server.

const $ = (id) => document.getElementById(id);
const canvas = $('canvas');
const screen = canvas.getContext('2d');
const shown = document.createElement('canvas'); // the view, at one pixel per image pixel
const pixels = shown.getContext('2d', { willReadFrequently: true });

let state = null;
let view = { scale: 1, x: 0, y: 0 }; // image position (0, 0) is at (x, y) on the canvas
let pointer = null; // its position in image pixels
let drag = null; // { kind, from, to }
let scheduled = false;
let pending = 0; // points that the server has not painted yet
let ended = false; // a stroke, whose state is not shown yet
let began = 0, dabs = 0; // the time when the stroke began, and the number of its points

// --- Server requests

async function ask(path, body) {
  const answer = await fetch(path, body === undefined ? {} : {
    method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body),
  });
  if (answer.ok) return answer;
  const error = await answer.json().catch(() => ({ message: answer.statusText }));
  throw new Error(error.message + (error.hint ? ` (${error.hint})` : ''));
}

function tell(text, wrong = false) {
  $('status').textContent = text;
  $('status').classList.toggle('error', wrong);
}

// Runs requests one after another, so that strokes arrive in the order in which they were drawn.
let queue = Promise.resolve();
let waiting = 0;
function enqueue(work) {
  ++waiting;
  document.body.dataset.busy = waiting;
  queue = queue.then(work).catch((error) => tell(error.message, true)).finally(() => {
    document.body.dataset.busy = --waiting;
  });
  return queue;
}

function take(fresh) {
  state = fresh;
  $('name').textContent = state.name;
  $('undo').disabled = !state.nib;
  $('nib').textContent = state.nib
    ? `Texture of ${state.nib.region.length === 4 ? state.nib.region.map((v) => Math.round(v)).join(', ') : `an outline of ${state.nib.region.length / 2} corners`}; ${state.strokes} strokes; φ ${state.nib.threshold.toFixed(3)}; error ${state.nib.error.toExponential(1)}`
    : 'No nib: drag a rectangle over the texture to paint with, or draw an outline around it.';
}

async function reload() {
  const kind = state.nib ? $('view').value : 'picture';
  const bytes = new Uint8ClampedArray(await (await ask(`/api/view?kind=${kind}`)).arrayBuffer());
  shown.width = state.width;
  shown.height = state.height;
  pixels.putImageData(new ImageData(bytes, state.width, state.height), 0, 0);
  draw();
}

async function chooseNib(region) {
  take(await (await ask('/api/nib', {
    region, levels: +$('levels').value, extent: +$('extent').value, finish: $('finish').value,
  })).json());
  tell('The nib is ready. Paint with it.');
  setTool('paint');
  await reload();
}

// Sends points and shows what is painted of them within a frame; the rest follows.
function paint(points, { begin = false, end = false }) {
  const radius = +$('size').value / 2;
  if (begin) began = performance.now(), dabs = 0;
  dabs += points.length;
  enqueue(() => stroke({ radius, points, begin, end }));
}

async function stroke(body) {
  const result = await (await ask('/api/stroke', body)).json();
  const [x0, y0, x1, y1] = result.rectangle;
  state.strokes = result.strokes;
  pending = result.pending;
  if (x1 > x0 && $('view').value === 'picture') {
    const bytes = Uint8ClampedArray.from(atob(result.pixels), (c) => c.charCodeAt(0));
    pixels.putImageData(new ImageData(bytes, x1 - x0, y1 - y0), x0, y0);
    draw();
  }
  ended ||= body.end;
  if (pending > 0) {
    tell(`${pending === 1 ? 'A dab' : `${pending} dabs`} to paint`);
    if (waiting === 1) enqueue(() => stroke({ points: [] }));
  } else {
    if (ended) {
      ended = false;
      tell(`Painted ${dabs === 1 ? 'a dab' : `${dabs} dabs`} in ${(performance.now() - began).toFixed(0)} ms`);
      take(await (await ask('/api/state')).json());
      if ($('view').value !== 'picture') await reload();
    }
  }
}

// --- Pointer input

const tool = () => document.querySelector('input[name=tool]:checked').value;
function setTool(name) {
  document.querySelector(`input[name=tool][value=${name}]`).checked = true;
  draw();
}

const place = (event) => {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left - view.x) / view.scale, (event.clientY - box.top - view.y) / view.scale];
};
// Rounds to quarters of a pixel, to keep saved strokes short.
const rounded = ([x, y]) => [Math.round(x * 4) / 4, Math.round(y * 4) / 4];
// Clamps to the image.
const held = ([x, y]) => rounded([Math.min(Math.max(x, 0), state.width), Math.min(Math.max(y, 0), state.height)]);
const inside = ([x, y]) => [Math.min(Math.max(Math.round(x), 0), state.width), Math.min(Math.max(Math.round(y), 0), state.height)];

canvas.addEventListener('pointerdown', (event) => {
  if (!state || event.button > 1) return;
  canvas.setPointerCapture(event.pointerId);
  const at = place(event);
  drag = { kind: event.button === 1 ? 'move' : tool(), from: at, to: at, corners: [held(at)] };
  if (drag.kind === 'paint') {
    if (!state.nib) {
      drag = null;
      tell('There is no nib yet: pick a region first.', true);
      return;
    }
    drag.last = rounded(at);
    paint([drag.last], { begin: true });
  }
});

canvas.addEventListener('pointermove', (event) => {
  pointer = place(event);
  if (drag?.kind === 'move') {
    view.x += event.movementX;
    view.y += event.movementY;
  } else if (drag?.kind === 'region') {
    drag.to = pointer;
  } else if (drag?.kind === 'outline') {
    const next = held(pointer), last = drag.corners.at(-1);
    // Limits the number of corners: long outlines get coarser.
    const step = drag.corners.length < 512 ? 2 : 16;
    if (Math.hypot(next[0] - last[0], next[1] - last[1]) >= step && drag.corners.length < 2048) drag.corners.push(next);
  } else if (drag?.kind === 'paint') {
    const next = rounded(pointer);
    // A large nib takes longer than the pointer to move by a pixel: then points are further apart.
    const step = pending > 4 ? Math.max(1, +$('size').value / 8) : 1;
    if (Math.hypot(next[0] - drag.last[0], next[1] - drag.last[1]) >= step) {
      drag.last = next;
      paint([next], {});
    }
  }
  draw();
});

canvas.addEventListener('pointerup', () => {
  const done = drag;
  drag = null;
  if (done?.kind === 'paint') paint([], { end: true });
  if (done?.kind === 'region') {
    const [x0, y0] = inside([Math.min(done.from[0], done.to[0]), Math.min(done.from[1], done.to[1])]);
    const [x1, y1] = inside([Math.max(done.from[0], done.to[0]), Math.max(done.from[1], done.to[1])]);
    if (x1 > x0 && y1 > y0) enqueue(() => chooseNib([x0, y0, x1 - x0, y1 - y0]));
  }
  if (done?.kind === 'outline') {
    if (done.corners.length >= 3) enqueue(() => chooseNib(done.corners.flat()));
    else tell('The outline is too short: drag all the way around the texture.', true);
  }
  draw();
});
canvas.addEventListener('pointerleave', () => {
  pointer = null;
  draw();
});

function zoomTo(scale, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
  scale = Math.min(Math.max(scale, 0.25), 32);
  view.x = x - ((x - view.x) / view.scale) * scale;
  view.y = y - ((y - view.y) / view.scale) * scale;
  view.scale = scale;
  draw();
}
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  const box = canvas.getBoundingClientRect();
  zoomTo(view.scale * Math.exp(-event.deltaY / 400), event.clientX - box.left, event.clientY - box.top);
}, { passive: false });
$('zoom').addEventListener('input', () => zoomTo(2 ** +$('zoom').value));

function undo() {
  enqueue(async () => {
    take(await (await ask('/api/undo', {})).json());
    pending = 0, ended = false;
    tell('Undone.');
    await reload();
  });
}
$('undo').addEventListener('click', undo);
$('save').addEventListener('click', () => enqueue(async () => {
  const saved = await (await ask('/api/save', {})).json();
  tell(`Saved to ${saved.file}${saved.note ? `: ${saved.note}` : ''}`, saved.note !== '');
}));
$('view').addEventListener('change', () => enqueue(reload));
// A change of extent, levels or finish creates a new nib from the same region.
for (const id of ['levels', 'extent', 'finish'])
  $(id).addEventListener('change', () => state?.nib && enqueue(() => chooseNib(state.nib.region)));
for (const id of ['size', 'levels', 'extent']) $(id).addEventListener('input', () => draw());
addEventListener('keydown', (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === 'z') return event.preventDefault(), undo();
  if (event.target.matches('input, select') || event.ctrlKey) return;
  const name = { r: 'region', o: 'outline', p: 'paint', ' ': 'move' }[event.key];
  if (name) event.preventDefault(), setTool(name);
});

// --- Drawing

function draw() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    const ratio = devicePixelRatio;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    screen.setTransform(view.scale * ratio, 0, 0, view.scale * ratio, view.x * ratio, view.y * ratio);
    screen.imageSmoothingEnabled = view.scale < 1;
    screen.drawImage(shown, 0, 0);
    screen.lineWidth = 1.5 / view.scale;
    screen.strokeStyle = '#ff4030';
    if (pointer && state && tool() === 'paint') {
      const radius = +$('size').value / 2;
      screen.beginPath();
      screen.arc(pointer[0], pointer[1], radius, 0, 2 * Math.PI);
      screen.stroke();
      screen.setLineDash([3 / view.scale, 3 / view.scale]); // the extent of the kernel
      screen.beginPath();
      screen.arc(pointer[0], pointer[1], radius + +$('extent').value, 0, 2 * Math.PI);
      screen.stroke();
      screen.setLineDash([]);
    }
    const box = drag?.kind === 'region'
      ? [drag.from[0], drag.from[1], drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]]
      : tool() === 'region' && state?.nib?.region.length === 4 ? state.nib.region : null;
    if (box) screen.strokeRect(...box);
    const corners = drag?.kind === 'outline' ? drag.corners.flat()
      : tool() === 'outline' && state?.nib?.region.length > 4 ? state.nib.region : null;
    if (corners) {
      screen.beginPath();
      for (let i = 0; i < corners.length; i += 2) screen.lineTo(corners[i], corners[i + 1]);
      if (drag?.kind !== 'outline') screen.closePath();
      screen.stroke();
    }
    $('size-text').textContent = `${$('size').value} px`;
    $('extent-text').textContent = `±${$('extent').value} px`;
    $('levels-text').textContent = $('levels').value;
    $('zoom-text').textContent = `${Math.round(view.scale * 100)} %`;
    $('zoom').value = Math.log2(view.scale);
  });
}
addEventListener('resize', draw);

// The token is now in a cookie, so remove it from the address bar and the history.
history.replaceState(null, '', '/');

enqueue(async () => {
  take(await (await ask('/api/state')).json());
  const fit = Math.min(canvas.clientWidth / state.width, canvas.clientHeight / state.height);
  view.scale = fit >= 1 ? Math.min(2 ** Math.floor(Math.log2(fit)), 8) : fit;
  view.x = Math.round((canvas.clientWidth - state.width * view.scale) / 2);
  view.y = Math.round((canvas.clientHeight - state.height * view.scale) / 2);
  await reload();
});

// For tests: the shown pixels, and the position of an image pixel on the page.
globalThis.terrazzo = {
  pixels: () => Array.from(pixels.getImageData(0, 0, shown.width, shown.height).data),
  screenAt: (x, y) => {
    const box = canvas.getBoundingClientRect();
    return [box.left + view.x + x * view.scale, box.top + view.y + y * view.scale];
  },
  state: () => state,
};
