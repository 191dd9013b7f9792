#include "nodes/bodies/carving/body.h"
#include "nodes/bodies/carving/parts.h"
#include "nodes/bodies/carving/ray_mesh.h"

namespace terrazzo::carving {
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
    Shape at = shape;
    at.mesh = placed_object(shape);
    return RayMesh(at);
  }
  RayMesh mesh_;
  std::unique_ptr<RayScene> scene_;
};

}  // namespace

std::unique_ptr<CarvedBody> object_body(const Shape& object) { return std::make_unique<Object>(object); }

}  // namespace terrazzo::carving
