#version 450 core
// No color output: only the stencil matters.
void main() {}
