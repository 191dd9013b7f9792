#include "nodes/bodies/carving/ray_scene.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "graph/diagnostic.h"

namespace terrazzo::carving {

namespace {

const char* words(RTCError e) {
  switch (e) {
    case RTC_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
      return "this processor is not supported";
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    default:
      return "unknown error";
  }
}

// One device for all scenes that exist: Embree cannot make a device for each of a thousand shapes.
std::shared_ptr<RTCDeviceTy> shared_device() {
  static std::mutex mutex;
  static std::weak_ptr<RTCDeviceTy> last;
  const std::lock_guard lock(mutex);
  if (auto device = last.lock()) return device;
  std::shared_ptr<RTCDeviceTy> device(rtcNewDevice(nullptr), [](RTCDevice d) {
    if (d) rtcReleaseDevice(d);
  });
  if (!device)
    throw Error("embree", std::string("the ray tracer Embree could not be set up: ") +
                              words(rtcGetDeviceError(nullptr)));
  last = device;
  return device;
}

}  // namespace

void require_moderate(const Vec3f& v) {
  if (!(v.array().abs() <= 1e15f).all())  // also NaN
    throw Error("bad-number", "a vertex is NaN, infinite or further than 1e15 mm from the origin",
                "check the lengths of the shapes, the particles and the volume");
}

struct RayScene::Handles {
  std::shared_ptr<RTCDeviceTy> device;
  RTCScene top = nullptr;
  bool plain = false;  // one mesh without transformation: no instances
  std::vector<RTCScene> meshes;
  ~Handles() {
    if (top) rtcReleaseScene(top);
    for (RTCScene s : meshes) rtcReleaseScene(s);
  }
};

namespace {

void check(RTCDevice device) {
  if (const RTCError e = rtcGetDeviceError(device); e != RTC_ERROR_NONE)
    throw Error("embree", std::string("the ray tracer Embree could not be set up: ") + words(e));
}

RTCScene new_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // watertight: no light leaks through shared edges
  return scene;
}

}  // namespace

RayScene::RayScene(const std::vector<Triangles>& meshes, const std::vector<Instance>& instances)
    : handles_(std::make_unique<Handles>()) {
  for (const Triangles& m : meshes)
    for (const Vec3f& p : m.positions) require_moderate(p);
  handles_->device = shared_device();
  RTCDevice device = handles_->device.get();
  tbb::task_arena alone(1);
  const auto commit = [&](RTCScene scene) { alone.execute([&] { rtcJoinCommitScene(scene); }); };

  for (const Triangles& m : meshes) {
    RTCScene scene = new_scene(device);
    handles_->meshes.push_back(scene);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                              m.positions.size());
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                            m.indices.size() / 3);
    check(device);
    std::memcpy(positions, static_cast<const void*>(m.positions.data()), m.positions.size() * 12);
    std::memcpy(indices, m.indices.data(), m.indices.size() * 4);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    commit(scene);
    check(device);
  }
  for (const Instance& i : instances)
    for (const Vec3f& p : meshes.at(i.mesh).positions) {
      const Vec3f at = i.linear * p + i.offset;
      require_moderate(at);
      bounds_.extend(at);
    }

  handles_->plain = meshes.size() == 1 && instances.size() == 1 && instances[0].linear.isIdentity(0) &&
                    instances[0].offset.isZero(0);
  if (handles_->plain) return;
  handles_->top = new_scene(device);
  for (std::size_t k = 0; k < instances.size(); ++k) {
    const Instance& i = instances[k];
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, handles_->meshes.at(i.mesh));
    float columns[12];
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) columns[c * 3 + r] = i.linear(r, c);
    for (int r = 0; r < 3; ++r) columns[9 + r] = i.offset[r];
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(handles_->top, geometry, static_cast<unsigned>(k));
    rtcReleaseGeometry(geometry);
  }
  commit(handles_->top);
  check(device);
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;

namespace {

RTCRay ray_of(const Vec3f& o, const Vec3f& d) {
  RTCRay ray{};
  ray.org_x = o.x();
  ray.org_y = o.y();
  ray.org_z = o.z();
  ray.dir_x = d.x();
  ray.dir_y = d.y();
  ray.dir_z = d.z();
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.mask = ~0u;
  return ray;
}

}  // namespace

bool RayScene::nearest(const Vec3f& origin, const Vec3f& direction, RayHit& out) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query;
  query.ray = ray_of(origin, direction);
  query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(handles_->plain ? handles_->meshes[0] : handles_->top, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  out = {query.ray.tfar, handles_->plain ? 0 : query.hit.instID[0], query.hit.primID, query.hit.u,
         query.hit.v};
  return true;
}

bool RayScene::any(const Vec3f& origin, const Vec3f& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_of(origin, direction);
  rtcOccluded1(handles_->plain ? handles_->meshes[0] : handles_->top, &context, &ray);
  return ray.tfar < 0;
}

}  // namespace terrazzo::carving
