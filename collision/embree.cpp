// Embree as broad phase: a hierarchy over the swept boxes of the patch, asked for everything near the tool's path.
//
// Embree keeps floats: coordinates are taken relative to the patch, and boxes are rounded outward. Committing a scene
// costs several microseconds and allocates, which a haptic tick must not; so the hierarchy holds boxes with a slack,
// and a triangle that leaves its box is kept in a short list beside the hierarchy until the next build (every refresh
// builds anew). Candidates are then sifted with the exact swept boxes. Never a hit distance of Embree's own is used.
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/triangle_index.hpp"

namespace kt {
namespace {

constexpr double kSlack = 0.5;  // of a triangle's box size: how far it may move within the hierarchy

struct Box {
  Vec3 low, high;
};

float round_down(double v) { return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity()); }
float round_up(double v) { return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity()); }

/// One Embree device for all patches: a device costs milliseconds to make. No threads of its own: the haptic loop must
/// not wait for any.
RTCDevice shared_device() {
  struct Device {
    RTCDevice handle = rtcNewDevice("threads=1,set_affinity=0");
    ~Device() { rtcReleaseDevice(handle); }
  };
  static Device device;
  return device.handle;
}

class EmbreeIndex final : public TriangleIndex {
 public:
  EmbreeIndex() = default;
  EmbreeIndex(const EmbreeIndex&) = delete;
  EmbreeIndex& operator=(const EmbreeIndex&) = delete;
  ~EmbreeIndex() override { release(); }

  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    release();
    triangles_.assign(triangles.begin(), triangles.end());
    held_.resize(triangles_.size());
    now_.resize(triangles_.size());
    escaped_.reserve(triangles_.size());
    escaped_.clear();
    origin_ = x.size() >= 3 ? Vec3(node(x, 0)) : Vec3(Vec3::Zero());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      now_[t] = swept(t, x, x);
      held_[t] = widened(now_[t]);
    }
    scene_ = rtcNewScene(shared_device());
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    geometry_ = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(triangles_.size()));
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(geometry_, bounds_of, this);
    rtcSetGeometryPointQueryFunction(geometry_, collect);
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_, geometry_);
    rtcCommitScene(scene_);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    escaped_.clear();
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Box& now = now_[t] = swept(t, x_t0, x_t1);
      const bool held =
          (now.low.array() >= held_[t].low.array()).all() && (now.high.array() <= held_[t].high.array()).all();
      if (!held) escaped_.push_back(static_cast<int>(t));
    }
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Vec3 a = sweep.x_t0 - origin_, b = sweep.x_t1 - origin_;
    Query query{this, out, 0, a.cwiseMin(b).array() - margin, a.cwiseMax(b).array() + margin};
    // Embree asks with a ball: the one around the path's box.
    const Vec3 centre = 0.5 * (query.low + query.high);
    RTCPointQuery ball{};
    ball.x = static_cast<float>(centre.x());
    ball.y = static_cast<float>(centre.y());
    ball.z = static_cast<float>(centre.z());
    ball.radius = round_up(0.5 * (query.high - query.low).norm() + 1e-6 * centre.norm());
    if (!std::isfinite(ball.radius)) return 0;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &ball, &context, nullptr, &query);
    for (int t : escaped_) query.add(t);
    std::sort(out.begin(), out.begin() + query.count);  // so that the result does not depend on the traversal
    return query.count;
  }

 private:
  struct Query {
    const EmbreeIndex* index;
    std::span<int> out;
    int count;
    Vec3 low, high;  // relative to the origin
    void add(int t) noexcept {
      const Box& box = index->now_[static_cast<std::size_t>(t)];
      const bool apart = (box.low.array() > high.array()).any() || (box.high.array() < low.array()).any();
      if (!apart && static_cast<std::size_t>(count) < out.size()) out[static_cast<std::size_t>(count++)] = t;
    }
  };

  Box swept(std::size_t t, const VectorX& x_t0, const VectorX& x_t1) const noexcept {
    Vec3 low = node(x_t0, triangles_[t][0]), high = low;
    for (int i : triangles_[t]) {
      low = low.cwiseMin(node(x_t0, i)).cwiseMin(node(x_t1, i));
      high = high.cwiseMax(node(x_t0, i)).cwiseMax(node(x_t1, i));
    }
    // A vertex that is not a number must not make its triangle vanish: everything is near it.
    if (!low.allFinite() || !high.allFinite()) return {Vec3::Constant(-1e30), Vec3::Constant(1e30)};
    return {low - origin_, high - origin_};
  }

  static Box widened(const Box& box) noexcept {
    const double slack = kSlack * (box.high - box.low).maxCoeff();
    return {box.low.array() - slack, box.high.array() + slack};
  }

  static void bounds_of(const RTCBoundsFunctionArguments* args) {
    const Box& box = static_cast<const EmbreeIndex*>(args->geometryUserPtr)->held_[args->primID];
    RTCBounds& out = *args->bounds_o;
    out.lower_x = round_down(box.low.x());
    out.lower_y = round_down(box.low.y());
    out.lower_z = round_down(box.low.z());
    out.upper_x = round_up(box.high.x());
    out.upper_y = round_up(box.high.y());
    out.upper_z = round_up(box.high.z());
  }

  static bool collect(RTCPointQueryFunctionArguments* args) {
    Query& query = *static_cast<Query*>(args->userPtr);
    const int t = static_cast<int>(args->primID);
    if (!std::binary_search(query.index->escaped_.begin(), query.index->escaped_.end(), t)) query.add(t);
    return false;  // the ball stays as large as it is
  }

  void release() {
    if (geometry_) rtcReleaseGeometry(geometry_);
    if (scene_) rtcReleaseScene(scene_);
    geometry_ = nullptr;
    scene_ = nullptr;
  }

  std::vector<Triangle> triangles_;
  std::vector<Box> held_, now_;  // relative to the origin: in the hierarchy, with slack; swept in this tick
  std::vector<int> escaped_;     // triangles outside their held box, ascending
  Vec3 origin_ = Vec3::Zero();
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_embree_triangle_index() { return std::make_unique<EmbreeIndex>(); }

}  // namespace kt
