// A registry of small node types on one-number tables, to test graphs and the evaluator.
#pragma once

#include "graph/graph.h"
#include "runtime/evaluate.h"

namespace terrazzo::test {

// Constant(value), Add(a, b), Clamp(in, low, high), Sum(in: list), SumInTurn(in: list), ListInTurn(in: list;
// a bug), FileSize(path), Fail(in), Endless(), Write(in, path), Sketch(value, wait)
const Registry& arithmetic();
const ValueTypes& value_types();

// Loads text as a graph and expects no errors.
Graph graph_of(const std::string& text, const Overrides& = {});
double number_of(const Value&);

// Number of nodes of a run with this status.
int count(const RunResult&, Status);
// Paths of the nodes with this status, sorted.
std::vector<std::string> paths(const Graph&, const RunResult&, Status);

}  // namespace terrazzo::test
