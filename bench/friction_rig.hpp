#pragma once
// Textbook problems of friction, solved by the engine's tick: a block on springs under a moving tool, and a free tool
// on a slope. Each has a closed form.
#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "haptics/tick/local_simulation.hpp"

namespace kt {

/// A block that moves without turning on springs along the axes; its top is one large triangle in the plane z = 0.
struct RigBlock {
  double mass = 1;                       ///< [kg]
  Vec3 stiffness = Vec3::Constant(1e3);  ///< [N/m]
  Vec3 damping = Vec3::Zero();           ///< [N s/m]
  LocalScheme scheme = LocalScheme::exact;

  std::unique_ptr<PreparedLocalModel> local_model(double h) const {
    constexpr double kHalf = 50;  // [m]
    LocalModel m;
    m.patch.triangles = {{0, 1, 2}};
    m.patch.global_triangle = {0};
    m.patch.global_node = {0, 1, 2};
    m.patch.on_rim = {0};
    m.patch.in_reach = {1, 1, 1};
    m.patch.topology = make_topology(m.patch.triangles, 3);
    m.recovered_node = {0, 1, 2};
    m.x0.resize(9);
    m.x0 << -kHalf, -kHalf, 0, kHalf, -kHalf, 0, 0, kHalf, 0;
    m.v0 = VectorX::Zero(9);
    m.f0 = m.q_rate0 = VectorX::Zero(3);
    const MatrixX all = Mat3::Identity().replicate(3, 1);
    m.basis = all.sparseView();
    m.lift = m.lift_rate = m.fit = m.fit_rate = SparseMatrix((all.transpose() / 3).sparseView());
    m.mass = Mat3(mass * Mat3::Identity()).sparseView();
    m.damping = MatrixX(damping.asDiagonal()).sparseView();
    m.stiffness = MatrixX(stiffness.asDiagonal()).sparseView();
    m.reducer = "block";
    return prepare(std::move(m), scheme, Metric::implicit, h, "brute_force", 3, 1);
  }
};

// ---- stick-slip: the tool is a belt that runs over the block ----

struct StickSlip {
  double speed = 0.02, normal_force = 0.2;  ///< of the belt [m/s]; [N]
  Friction friction{0.5, 0.3};
  RigBlock block{.mass = 0.05, .stiffness = {20, 20, 1e3}, .damping = {0, 0, 10}};
};

struct StickSlipMotion {
  double period = 0;               ///< [s]
  double lowest = 0, highest = 0;  ///< of the block [m]
  double stick_slip_apart = 0;     ///< while it sticks: largest change of the way between block and belt [m]
};

/// While it sticks the spring is drawn at the belt's speed to mu_s N / k; then the block swings about mu_k N / k until
/// it has the belt's speed again.
inline StickSlipMotion closed_form(const StickSlip& s) {
  const double k = s.block.stiffness.x(), omega = std::sqrt(k / s.block.mass);
  const double centre = s.friction.mu_kinetic * s.normal_force / k;
  const double ahead = s.friction.mu_static * s.normal_force / k - centre;
  const double angle = std::atan(s.speed / (omega * ahead)), amplitude = std::hypot(ahead, s.speed / omega);
  return {2 * ahead / s.speed + (std::acos(-1.0) + 2 * angle) / omega, centre - amplitude, centre + amplitude, 0};
}

/// Over `periods` whole ones, after as many that settle.
inline StickSlipMotion measure(const StickSlip& s, double h, int periods) {
  LocalSimulation local(ToolShape{}, h, make_contact_solver("coulomb", s.friction));
  local.adopt(s.block.local_model(h));
  const double depth = s.normal_force / s.block.stiffness.z();
  Vec3 at(0, 0, 1e-4);
  const auto step = [&](const Vec3& next) {
    const LocalFrame frame = local.step({at, next});
    at = next;
    return frame;
  };
  const int press = static_cast<int>(std::lround(0.05 / h));
  for (int i = 1; i <= press; ++i) step({0, 0, 1e-4 + i * (-depth - 1e-4) / press});

  StickSlipMotion out{0, 1e9, -1e9, 0};
  double first = 0, last = 0, anchor = 0;
  int counted = -periods;
  bool stuck = false;
  for (long i = 0; counted <= periods && i < static_cast<long>(1e3 / h); ++i) {
    const LocalFrame frame = step({at.x() + s.speed * h, 0, -depth});
    const bool sticks = frame.mode == ContactMode::stick;
    const double x = local.model().state.q.x();
    if (stuck && !sticks) {  // a period ends where it begins to slip
      if (counted == 0) first = frame.t;
      if (counted == periods) last = frame.t;
      ++counted;
    }
    if (counted > 0) {
      out.lowest = std::min(out.lowest, x);
      out.highest = std::max(out.highest, x);
      if (sticks && stuck) out.stick_slip_apart = std::max(out.stick_slip_apart, std::abs(at.x() - x - anchor));
    }
    if (sticks && !stuck) anchor = at.x() - x;
    stuck = sticks;
  }
  out.period = (last - first) / periods;
  return out;
}

// ---- a free tool, moved by given forces, on the block ----

struct FreeTool {
  double mass = 1, radius = 0;              ///< [kg]; [m], 0: it does not turn
  double damping = 0;                       ///< [N s/m]
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();  ///< [m], [m/s]
  Vec3 spin = Vec3::Zero();                 ///< [rad/s]
};

/// Steps the tool over the block for `seconds` under `force(t)` [N]; `visit(frame, tool, block)` after each tick.
/// Semi-implicit Euler, one tick behind the contact force, as a device is.
template <class Force, class Visit>
void run_free_tool(FreeTool& tool, const RigBlock& block, const Friction& friction, double h, double seconds,
                   Force force, Visit visit) {
  const ToolShape shape{tool.radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, tool.radius};
  LocalSimulation local(shape, h, make_contact_solver("coulomb", friction));
  auto model = block.local_model(h);
  // The block is where the tool has pressed it: no overlap, which would be pushed out.
  model->state.q.z() = std::min(0.0, tool.x.z() - tool.radius);
  local.adopt(std::move(model));
  Quaternion pose = Quaternion::Identity();
  Vec3 from_body = Vec3::Zero(), torque = Vec3::Zero();
  const long ticks = std::lround(seconds / h);
  for (long i = 0; i < ticks; ++i) {
    tool.v += h / tool.mass * (force(static_cast<double>(i) * h) + from_body - tool.damping * tool.v);
    const Vec3 next = tool.x + h * tool.v;
    Quaternion turned = pose;
    if (tool.radius > 0) {
      tool.spin += h / (0.4 * tool.mass * tool.radius * tool.radius) * torque;
      const double angle = h * tool.spin.norm();
      if (angle > 0) turned = (Eigen::AngleAxisd(angle, tool.spin.normalized()) * pose).normalized();
    }
    const LocalFrame frame = local.step({tool.x, next, pose, turned});
    tool.x = next;
    pose = turned;
    from_body = frame.force;
    torque = frame.torque;
    visit(frame, tool, local.model().state);
  }
}

/// Rises smoothly from 0 to 1 within `time`.
inline double ramp(double t, double time) {
  const double s = std::min(1.0, t / time);
  return s * s * (3 - 2 * s);
}

/// A tool of 0.1 kg pressed with 1 N and pushed along the surface with `share` of mu F_N for `seconds`: how far it goes
/// after the first two seconds [m].
inline double creep(double share, double h, double seconds) {
  const double mu = 0.5;
  FreeTool tool{.mass = 0.1, .damping = 10};
  const RigBlock block{.mass = 1e-3, .stiffness = {1e3, 1e3, 1e3}, .damping = {1, 1, 1}};
  double start = 0;
  run_free_tool(
      tool, block, {mu, mu}, h, 2 + seconds,
      [&](double t) { return Vec3(share * mu * ramp(t - 0.5, 1), 0, -ramp(t, 0.4)); },
      [&](const LocalFrame& frame, const FreeTool& now, const LocalState&) {
        if (frame.t < 2) start = now.x.x();
      });
  return std::abs(tool.x.x() - start);
}

/// Whether a tool slides down a slope of the given angle [rad] under its own weight, put on gently.
inline bool slides_down(double angle, double mu, double h) {
  FreeTool tool{.mass = 0.1, .damping = 5};
  const RigBlock block{.mass = 1e-3, .stiffness = {1e3, 1e3, 1e3}, .damping = {1, 1, 1}};
  double slip = 0;
  run_free_tool(
      tool, block, {mu, mu}, h, 4,
      [&](double t) { return Vec3(9.81 * tool.mass * ramp(t, 2) * Vec3(std::sin(angle), 0, -std::cos(angle))); },
      [&](const LocalFrame& frame, const FreeTool& now, const LocalState& state) {
        if (frame.t < 1) slip = now.x.x() - state.q.x();
      });
  return tool.x.x() - 9.81 * tool.mass * std::sin(angle) / 1e3 - slip > 1e-6;
}

/// Critical angle by bisection: its tangent / mu - 1.
inline double critical_slope_error(double mu, double h) {
  double low = 0.9 * mu, high = 1.1 * mu;
  for (int i = 0; i < 16; ++i) {
    const double middle = 0.5 * (low + high);
    (slides_down(std::atan(middle), mu, h) ? high : low) = middle;
  }
  return 0.5 * (low + high) / mu - 1;
}

struct Stop {
  double distance = 0;  ///< that a tool slides which begins at `speed` [m]
  double closed_form = 0;
  double lost = 0, friction_work = 0;  ///< kinetic energy; mu N times the way the tool slid over the block [J]
};

/// A tool of 1 kg lies on a stiff block under its weight and is given a speed [m/s].
inline Stop slide_to_rest(double speed, double mu, double h) {
  constexpr double kWeight = 9.81;
  FreeTool tool{.mass = 1};
  const RigBlock block{.mass = 1e-3, .stiffness = {1e5, 1e5, 1e4}, .damping = {2, 2, 150}};
  tool.x.z() = -kWeight / block.stiffness.z();
  Stop out;
  out.closed_form = speed * speed / (2 * mu * kWeight);
  tool.v.x() = speed;
  double before = 0;
  run_free_tool(
      tool, block, {mu, mu}, h, 2 * speed / (mu * kWeight), [&](double) { return Vec3(0, 0, -kWeight); },
      [&](const LocalFrame& frame, const FreeTool& now, const LocalState& state) {
        const double apart = now.x.x() - state.q.x();
        if (frame.mode == ContactMode::frictional_slide) out.friction_work += frame.f_t * (apart - before);
        before = apart;
      });
  out.distance = tool.x.x();
  out.lost = 0.5 * tool.mass * (speed * speed - tool.v.squaredNorm());
  return out;
}

/// A ball rolls down a slope from rest: its way after a second over 5/14 g sin(angle) s^2, - 1.
inline double rolling_error(double angle, double mu, double h) {
  FreeTool tool{.mass = 1, .radius = 0.05};
  const RigBlock block{.mass = 1e-3, .stiffness = {1e5, 1e5, 1e4}, .damping = {20, 20, 200}};
  const Vec3 weight = 9.81 * tool.mass * Vec3(std::sin(angle), 0, -std::cos(angle));
  tool.x.z() = tool.radius + weight.z() / block.stiffness.z();
  run_free_tool(
      tool, block, {mu, mu}, h, 1, [&](double) { return weight; },
      [](const LocalFrame&, const FreeTool&, const LocalState&) {});
  return tool.x.x() / (5.0 / 14 * 9.81 * std::sin(angle)) - 1;
}

}  // namespace kt
