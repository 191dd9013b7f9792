#include "graph/node_type.h"
#include "nodes/common/io/reading.h"
#include "nodes/packing/load_particles/read_particles.h"
#include "runtime/context.h"

namespace terrazzo::load_particles {
namespace {

Particles particles_in(const std::filesystem::path& file, Context& c) {
  try {
    const std::string text = read_whole(file, reading_of(c));
    require_memory(memory_to_read(text), c.memory(), "the packing '" + file.string() + "'");
    return read_particles(text, file.string());
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

void compute(Context& c) {
  const auto& files = c.files("path");
  if (files.size() != 1)
    throw Error("several-files", "the path matches " + std::to_string(files.size()) + " files; one is needed",
                "name one file")
        .parameter("path");
  Particles p = particles_in(files.front(), c);
  c.metric("particles", p.count());
  c.metric("voids", p.void_count());
  c.metric("box_x", p.box[0]);
  c.metric("box_y", p.box[1]);
  c.metric("box_z", p.box[2]);
  c.output("particles", std::move(p));
}

}  // namespace
}  // namespace terrazzo::load_particles

namespace terrazzo {

NodeType load_particles_node() {
  using namespace load_particles;
  return NodeType("LoadParticles", 1)
      .doc_(
          "Reads a packing that Export wrote to .json, or that an interrupted Anneal or Pack saved, without "
          "loss of precision. Connect it to `start` of Anneal to continue an interrupted packing.")
      .output("particles", "Particles", "The packing, without its shapes")
      .parameter(Parameter::input_path("path").doc_("JSON file with the fields of particles"))
      .compute_(compute);
}

}  // namespace terrazzo
