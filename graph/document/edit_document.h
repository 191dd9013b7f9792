// Edits of a graph file that keep everything else of its text: comments, order, formatting.
#pragma once

#include <string>
#include <vector>

#include "graph/document/raw_document.h"

namespace terrazzo {

struct Edit {
  enum class Kind {
    SetParameter,    // node, name, value
    ResetParameter,  // node, name: removes the value, so that the default applies
    AppendItem,      // node, name, value: a word, at the end of a list; makes a list of what is no list
    RemoveItem,      // node, name, index: an item of a list; with the last item goes the value
    SetDefault,      // name, value: of a parameter of the graph
    SetSubgraph,     // node, graph: the file of a node that is a subgraph
    SetBypass,       // node, bypass
    Connect,         // node, name: an input; wires: its sources, none disconnects it
    Rewire,          // name, to: outputs "NODE.PORT". What reads the first reads the second, except node
    AddNode,         // node; type, or graph for a subgraph
    RemoveNode,      // node, with the wires and the outputs of the graph that refer to it
    RenameNode       // node, to
  };
  Kind kind = Kind::SetParameter;
  std::string node = {}, name = {};
  WrittenValue value = {};
  std::vector<std::string> wires = {};
  std::string type = {}, graph = {}, to = {};
  std::size_t index = 0;
  bool bypass = false;
};

// The text of a graph file, and what it says.
struct ReadGraph {
  std::string text;
  RawDocument document;
  Diagnostics found;  // what read_document() reported
};
ReadGraph read_graph(std::string text, const std::filesystem::path& file);

// The text after the edit. The result is read again: it differs from the original document in exactly what
// the edit says. Throws Error "unknown-node", "unknown-item", "name-taken" or "bad-name", and "cannot-edit"
// if the text has errors or says this in a way that a patch cannot change; such text can only be edited by
// hand.
std::string edit_document(const std::string& text, const std::filesystem::path& file, const Edit&);
// The same, which spares reading the text before and afterwards.
ReadGraph edit_document(const ReadGraph&, const std::filesystem::path& file, const Edit&);

}  // namespace terrazzo
