// Random edits of graph files, and what they mean.
#pragma once

#include <random>
#include <string>

#include "graph/document/edit_document.h"

namespace terrazzo::test {

// Whether a wire names an output of the node.
bool names(const std::string& wire, const std::string& node);

// The document after the edit, found without its text.
RawDocument intended(RawDocument, const Edit&);

class RandomEdits {
 public:
  // An edit of any kind that the document allows. `number`: for the names of new nodes.
  Edit next(const RawDocument&, std::size_t number);

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  template <class List>
  const auto& pick(const List& list) {
    return list[below(list.size())];
  }
  std::string word();
  WrittenValue value();
  std::string wire(const RawDocument& doc) { return pick(doc.nodes).name + (below(4) ? ".out" : "[3].out"); }

  std::mt19937 random_{20};
};

}  // namespace terrazzo::test
