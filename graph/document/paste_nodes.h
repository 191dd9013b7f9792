// Nodes as text, copied from a graph file into another one.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "graph/document/raw_document.h"

namespace terrazzo {

struct Pasted {
  std::string text;                                        // of the document with the nodes
  std::vector<std::pair<std::string, std::string>> names;  // as they were copied, and as they are now
};

// Adds nodes behind those of the document, with their comments and formatting. `nodes`: lines below `nodes:`
// of a graph file, or a whole file. A node whose name is taken gets a number, and wires between the nodes
// follow. Wires from nodes that neither text has are left out. Throws Error "no-nodes" if the text is
// something else, "too-large" if it has more than 500 nodes, and "cannot-edit" as edit_document() does.
Pasted paste_nodes(const std::string& text, const std::filesystem::path& file, const std::string& nodes);

}  // namespace terrazzo
