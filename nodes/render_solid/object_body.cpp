#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/render_solid/body.h"
#include "nodes/render_solid/ray_mesh.h"

namespace terrazzo::render_solid {
namespace {

class Object : public CarvedBody {
 public:
  explicit Object(const Shape& shape) : mesh_(placed(shape)) {
    scene_ = std::make_unique<RayScene>(std::vector<RayScene::Triangles>{mesh_.triangles},
                                        std::vector<RayScene::Instance>{{}});
  }
  bool meet(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, float& at) const override {
    RayHit hit;
    if (!scene_->nearest(origin, direction, hit)) return false;
    at = hit.distance;
    s.position = origin + hit.distance * direction;
    mesh_.normals_at(hit, s.face, s.normal);
    s.open = false;
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return scene_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return scene_->bounds(); }

 private:
  static RayMesh placed(const Shape& shape) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : shape.mesh.vertices) box.extend(v);
    const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
    if (!(longest > 0) || !std::isfinite(longest))
      throw Error("bad-mesh", "the object '" + shape.name + "' has no extent");
    return RayMesh(shape, -box.min(), 1 / longest);
  }
  RayMesh mesh_;
  std::unique_ptr<RayScene> scene_;
};

}  // namespace

std::unique_ptr<CarvedBody> object_body(const Shape& object) { return std::make_unique<Object>(object); }

}  // namespace terrazzo::render_solid
