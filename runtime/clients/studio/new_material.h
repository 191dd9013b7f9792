// New graph files: of a photograph, and copies of a graph in another folder.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "graph/registry.h"
#include "nodes/media/micrograph/recommend.h"
#include "runtime/clients/studio/workspace.h"

namespace terrazzo::studio {

// What a photograph is taken for.
enum class Content { Particles, Phases };

// Values of parameters of the graph: {"pixel_size", "0.05"}.
using Settings = std::vector<std::pair<std::string, std::string>>;

// Whether LoadImage reads files with this extension.
bool is_picture_name(const std::filesystem::path&);

// A graph with a photograph: of particles, library/aggregate.yaml with the nodes of materials/aggregate.yaml
// that render and write files; of phases, library/media.yaml. `photo`: the path as the graph states it.
// Throws Error "no-library" if these graphs are not installed, and what edit_document() throws.
std::string graph_of_photograph(const std::string& photo, const std::string& title, Content, const Settings&);

// What to take the bytes of a picture for. Throws what create_graph() throws for them.
media::Recommendation recommend(const std::string& bytes, const std::string& name);

struct NewFile {
  std::filesystem::path path;
  bool written;  // else the file existed, with this content
};

// Writes a file under a name, or with a number if that exists. If one of these files has the content already,
// it is taken. Throws Error "write-failed".
NewFile write_once(const std::filesystem::path&, const std::string& content);

// Writes a graph of the photograph's particles into a folder, as "STEM.yaml", or with a number if that is
// another graph. Throws Error "unreadable-image" and others of read_image(), "bad-name", "write-failed".
NewFile create_graph(const std::filesystem::path& photo, const std::filesystem::path& folder,
                     const Settings&);

// The same for a photograph's bytes, which are written beside the graph under `name`, or with a number if
// that is another picture. Writes nothing if they are no picture.
NewFile create_graph(const std::string& bytes, const std::string& name, const std::filesystem::path& folder,
                     Content, const Settings&);

// The text of a graph at `from` as it must be at `to`, so that it refers to the same files. References are
// relative if both lie in the workspace, otherwise absolute.
std::string relocated(const std::string& text, const std::filesystem::path& from,
                      const std::filesystem::path& to, const Workspace&, const Registry&);

}  // namespace terrazzo::studio
