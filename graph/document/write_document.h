// Writes a document in the style of the graphs in graphs/, as a person would.
#pragma once

#include <string>

#include "graph/document/raw_document.h"

namespace terrazzo {

// The text of a graph file. Reading it gives an equal document, apart from the places.
//
// `original` is the text that the document was read from, if there is one. Then the text of everything that
// is unchanged is kept, with its comments; a changed node or parameter is written again below its comment.
std::string write_document(const RawDocument&, const std::string& original = {});

// Whether two documents say the same. Ignores places and the name of the file.
bool same_document(const RawDocument&, const RawDocument&);

}  // namespace terrazzo
