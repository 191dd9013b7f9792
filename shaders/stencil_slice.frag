#version 450 core
// Nothing to shade: only the stencil counts.
void main() {}
