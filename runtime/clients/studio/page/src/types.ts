// What the server sends: see runtime/clients/studio/server/studio_server.h.
export interface Port { name: string; types: string[]; doc: string; optional: boolean; many: boolean }
export interface Parameter {
  name: string; kind: string; doc: string; unit: string; required: boolean;
  choices: string[]; keywords: string[]; default?: unknown; min?: number; max?: number; min_open?: boolean;
}
export interface NodeType {
  type: string; district: string; version: number; doc: string; source: string; writes_files: boolean;
  inputs: Port[]; outputs: Port[]; parameters: Parameter[];
}
export type Written = string | string[];
export interface DocNode {
  name: string; type: string; graph: string; doc: string; line: number; bypass: boolean;
  params: Record<string, { value: Written; line: number }>;
  inputs: Record<string, string[]>;
  each?: Record<string, { value: Written; line: number }>;
  declaration?: NodeType;
  parts?: string[]; // nodes that are drawn within this one's card
  inner?: Record<string, { path: string; port: string } | null>; // what makes each output of a subgraph, or of a bypassed node
}
export interface Message {
  severity: 'error' | 'warning' | 'note'; code: string; message: string; hint: string;
  file: string; line: number; column: number; node: string; parameter: string;
}
export interface GraphParameter {
  name: string; kind: string; doc: string; unit: string; choices: string[]; keywords: string[]; line: number; value: Written;
}
export interface Doc {
  name: string; doc: string; file: string; text: string;
  nodes: DocNode[]; node_count?: number; // of the document, not of subgraphs; with more than 2,000, `nodes` is empty
  outputs: { name: string; wire: string; line: number }[];
  parameters: GraphParameter[]; messages: Message[];
  saved: boolean; read_only: boolean; can_undo: boolean; can_redo: boolean; recovered: string; trouble: string;
  disk_changed: boolean; valid: boolean; varied: boolean; arrangement: Arrangement;
}
export interface StartInfo {
  welcome: boolean; folder: string; materials: { name: string; title: string; doc: string; picture: boolean }[];
  graphs: { file: string; changed: number }[]; // below the folder, newest first
  bundles: { file: string; title: string; doc: string; picture: boolean }[]; // the same
}
export interface OutputValue { type: string; hash: string; bytes: number } // hash of a preview: "preview/NUMBER"
export type StateWord = 'cached' | 'stale' | 'waiting' | 'running' | 'computed' | 'failed' | 'skipped' | 'canceled' | 'bypassed';
export interface NodeState {
  type: string; since?: number; // since: when it started, by performance.now()
  state: StateWord; progress: number; note: string; seconds: number; expected: number; reasons: string[];
  outputs: Record<string, OutputValue>; previews: Record<string, { type: string; number: number }>;
  metrics: Record<string, number>; warnings: string[]; files: string[];
  error?: Message; elapsed?: number; // of a node that runs, when it was reported
}
export interface Run { running: boolean; live: boolean; seconds: number; expected: number; unfinished: number; trouble: string }
export interface Variant {
  value: string; state: 'waiting' | 'running' | 'preview' | 'done' | 'failed' | 'canceled'; doing: string; progress: number; seconds: number;
  output?: OutputValue; shapes?: OutputValue; preview?: { type: string; number: number }; error: string;
}
export interface Variants { target: string; values: string; node: string; port: string; scope: string; running: boolean; tiles: Variant[] }
export interface State { number: number; document: Doc; nodes: Record<string, NodeState>; run: Run; variants: Variants | null }
export interface Note { x: number; y: number; width: number; height: number; text: string; frame: boolean }
export interface Arrangement { places?: Record<string, [number, number]>; notes?: Note[] }
export interface Price { nodes: { path: string; seconds: number; reason: string; perhaps: boolean }[]; seconds: number }
export interface Past { number: number; nodes: Record<string, { outputs: Record<string, OutputValue>; metrics: Record<string, number> }> }
