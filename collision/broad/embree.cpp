// Embree as broad phase: a hierarchy over the swept boxes of the patch, asked for everything near the tool's path.
//
// Embree keeps floats: coordinates are taken relative to the patch, and boxes are rounded outward. Committing a scene
// costs several microseconds and allocates, which a haptic tick must not; so the hierarchy holds boxes with a slack,
// and a triangle that leaves its box is kept in a short list beside the hierarchy until the next build (every refresh
// builds anew). A refit tests only triangles with a vertex that has moved by more than its slack. Embree drops boxes
// that are not finite or very large without a word: such triangles are in the list from the start. Candidates are then
// sifted with the exact swept boxes. Never a hit distance of Embree's own is used.
#if KT_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "collision/broad/triangle_index.hpp"
#include "collision/shape/swept_box.hpp"
#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr double kSlack = 0.5;  // of a triangle's box size: how far it may move within the hierarchy
constexpr double kFar = 1e15;   // Embree leaves out boxes beyond 1.8e18

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

/// Embree reports a failure only when asked; a scene that lacks its triangles would miss impacts.
void require_success() {
  const RTCError error = rtcGetDeviceError(shared_device());
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error == RTC_ERROR_UNKNOWN)
    throw RunError("collision.backend embree could not start, as with too little memory: free some, or set it to auto");
  if (error != RTC_ERROR_NONE)
    throw RunError(text("collision.backend embree gave up (its error ", static_cast<int>(error), "); set it to auto"));
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
    escaped_.reserve(triangles_.size());
    choose_origin(x);
    built_ = x_t0_ = x_t1_ = x;
    leaves_.assign(static_cast<std::size_t>(x.size() / 3), 0);
    held_.clear();
    for (const Triangle& t : triangles_) held_.push_back(widened(swept_box(t, x, x)));
    find_slack();
    if (!shared_device()) require_success();
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
    require_success();
    refit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    escaped_.clear();
    x_t0_ = x_t0.head(built_.size());  // there may be more vertices, of an apron
    x_t1_ = x_t1.head(built_.size());
    if (!find_leaving(x_t0, x_t1)) return;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Triangle& v = triangles_[t];
      if (!(leaves_[v[0]] | leaves_[v[1]] | leaves_[v[2]])) continue;
      const Box now = swept_box(v, x_t0, x_t1);
      const bool held =
          (now.low.array() >= held_[t].low.array()).all() && (now.high.array() <= held_[t].high.array()).all();
      if (!held) escaped_.push_back(static_cast<int>(t));
    }
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    Query query{this, out, 0, path_box(sweep, margin)};
    // Embree asks with a ball: the one around the path's box, and what its floats lose.
    const Vec3 centre = 0.5 * (query.path.low + query.path.high) - origin_;
    const double radius = 0.5 * (query.path.high - query.path.low).norm();
    if (!(radius + centre.norm() < kFar)) return sift_all(query);
    RTCPointQuery ball{};
    ball.x = static_cast<float>(centre.x());
    ball.y = static_cast<float>(centre.y());
    ball.z = static_cast<float>(centre.z());
    ball.radius = round_up(1.000001 * (radius + 1e-6 * centre.norm()));
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
    Box path;
    void add(int t) noexcept {
      if (!is_apart(swept_box(index->triangles_[t], index->x_t0_, index->x_t1_), path)) out[count++] = t;
    }
  };

  int sift_all(Query& query) const noexcept {
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) query.add(t);
    return query.count;
  }

  /// How far each vertex may move along an axis without a triangle of it leaving its box; none from nowhere.
  void find_slack() {
    constexpr double kRoundoff = 1 - 1e-9;
    slack_.setConstant(built_.size(), std::numeric_limits<double>::infinity());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Box box = swept_box(triangles_[t], built_, built_);
      const bool is_near = held_[t].low.x() <= held_[t].high.x();
      const double slack = is_near ? kRoundoff * (box.low - held_[t].low).minCoeff() : -1;
      for (const int v : triangles_[t]) node(slack_, v) = node(slack_, v).cwiseMin(slack);
    }
  }

  /// Vertices that are not within their slack at both ends, as one with a coordinate that is not finite.
  bool find_leaving(const VectorX& x_t0, const VectorX& x_t1) noexcept {
    unsigned char any = 0;
    for (std::size_t v = 0; v < leaves_.size(); ++v) {
      unsigned char within = 1;
      for (const VectorX* x : {&x_t0, &x_t1})
        for (Eigen::Index i = 3 * static_cast<Eigen::Index>(v), k = 0; k < 3; ++k)
          within &= std::abs((*x)[i + k] - built_[i + k]) <= slack_[i + k];
      leaves_[v] = !within;
      any |= leaves_[v];
    }
    return any;
  }

  /// Where the floats count from: the first vertex that is somewhere.
  void choose_origin(const VectorX& x) {
    origin_.setZero();
    for (int v = 0; v < static_cast<int>(x.size() / 3); ++v)
      if (node(x, v).allFinite()) {
        origin_ = node(x, v);
        return;
      }
  }

  /// The box that the hierarchy holds; one that nothing fits in, for a triangle that Embree would leave out.
  Box widened(const Box& box) const noexcept {
    const double slack = kSlack * (box.high - box.low).maxCoeff();
    const Box out{box.low.array() - slack, box.high.array() + slack};
    const bool is_near = (out.low - origin_).minCoeff() > -kFar && (out.high - origin_).maxCoeff() < kFar;
    return is_near ? out : Box{everywhere().high, everywhere().low};
  }

  static void bounds_of(const RTCBoundsFunctionArguments* args) {
    const auto* const index = static_cast<const EmbreeIndex*>(args->geometryUserPtr);
    const Box& box = index->held_[args->primID];
    const bool is_held = box.low.x() <= box.high.x();
    const Vec3 low = is_held ? Vec3(box.low - index->origin_) : Vec3(Vec3::Zero());
    const Vec3 high = is_held ? Vec3(box.high - index->origin_) : Vec3(Vec3::Zero());
    RTCBounds& out = *args->bounds_o;
    out.lower_x = round_down(low.x());
    out.lower_y = round_down(low.y());
    out.lower_z = round_down(low.z());
    out.upper_x = round_up(high.x());
    out.upper_y = round_up(high.y());
    out.upper_z = round_up(high.z());
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
  std::vector<Box> held_;              // in the hierarchy, with slack
  VectorX built_, slack_;              // vertices at the build, and how far they may move along each axis (3p)
  VectorX x_t0_, x_t1_;                // vertices in this tick (3p)
  std::vector<unsigned char> leaves_;  // of each vertex
  std::vector<int> escaped_;           // triangles outside their held box, ascending
  Vec3 origin_ = Vec3::Zero();
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_embree_triangle_index() { return std::make_unique<EmbreeIndex>(); }

}  // namespace kt
