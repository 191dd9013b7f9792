// What RenderSolid and Carve share: the inputs and parameters that describe a solid and a body made of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "graph/node_type.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"
#include "runtime/context.h"

namespace terrazzo {
struct Profiles;
}

namespace terrazzo::carving {

class ColorField;
struct HiddenVoid;

enum class Mode { Auto, Block, Cube, Object, Vase, Knot, Fracture, Particles };
// The words of `mode`, in the order of Mode. Carve leaves out the last.
extern const std::vector<std::string> kModes;
// The parameter `mode`; `photograph` may be null. Auto: particles if the photograph shows loose stones, else
// object if one is connected, else block if there is a volume or a photograph, else particles.
Mode resolved_mode(const Context&, const Profiles* photograph);

// Declares the inputs volume, particles, shapes, object and detail, the last one last.
void declare_solid(NodeType&);
// Declares color, repeat, turn, shift, cut, level and roughness.
void declare_body(NodeType&);
// Throws Error "bad-turn", "bad-shift".
void check_body(const NodeParameters&);

// The body that a node's inputs and parameters describe, with what its colors come from.
struct Body {
  std::unique_ptr<residual::ResidualField> residual;
  std::unique_ptr<residual::Skins> skins;  // for Particles, of a photograph of a surface
  std::unique_ptr<ColorField> field;
  std::unique_ptr<Paint> paint;  // null for Particles
  std::unique_ptr<Solid> solid;
  std::unique_ptr<HiddenVoid> hidden;
  Voids voids;    // that open in the body; none for Fracture and Particles
  double mm = 1;  // per world unit

  Body();
  ~Body();
  Body(Body&&) noexcept;
};

// Throws Error "no-INPUT" for inputs that the mode needs, and the errors of the solids and of
// hidden_voxels(). `seed` shapes the face of a fracture; `hide`: phases of the volume that are holes.
Body body_of(Context&, Mode, std::uint64_t seed, const std::vector<std::int64_t>& hide = {});
// The connected object. Throws Error "no-object", "no-shapes".
const Shape& object_of(Context&, bool warn);

}  // namespace terrazzo::carving
