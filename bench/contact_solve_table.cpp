// What one contact solve costs, by number of contacts: p50 and p99 over ticks that follow one another, sweeps, share of
// ticks that converge, and the figures of a peer's frozen-contact kernel (docs/friction.md).
//   build/release/bench/contact_solve_table [--ticks N] [--csv FILE]
// body: a blunt tool presses a soft block, moves to and fro on it and goes up and down, so that contacts open, stick
// and slip; one coefficient (0.5), or two (0.6 and 0.4). random: operators of random bodies, other velocities each
// tick.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>

#include "core/base/percentile.hpp"
#include "core/local/local_dynamics.hpp"
#include "haptics/contact/contact_sweeps.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

constexpr int kRepeats = 5;  // the least of them is a solve's time: the rest is the scheduler's
constexpr double kDemanded = 1e-6;
constexpr struct {
  int contacts;
  double p50_us, converged;
} kPeer[] = {{1, 0.2, 1},     {4, 1.5, 1},      {10, 8, 0.999},  {20, 16, 0.995},
             {35, 55, 0.984}, {50, 138, 0.965}, {100, 580, 0.85}};

/// One tick's contacts.
struct Tick {
  std::vector<Vec3> normal;
  std::vector<Friction> friction;
  VectorX velocity;
  MatrixX W;
  ContactSystem system() const { return {normal, friction, {}, velocity, W}; }
};

struct Row {
  std::vector<double> us, single_us;
  std::vector<int> sweeps;
  double worst = 0;
  int converged = 0, slips = 0, sticks = 0, open = 0;
};

/// Solves from `impulse`, which becomes the solution.
void measure(ContactSweeps& solver, const Tick& tick, VectorX& impulse, Row& out) {
  const ContactSystem system = tick.system();
  std::vector<ContactMode> mode(tick.normal.size());
  const int batch = std::max(1, 20 / static_cast<int>(mode.size()));  // short ones are timed together
  const VectorX start = impulse;
  double least = 1e300, first = 0;
  SweepResult result;
  for (int k = 0; k < kRepeats; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < batch; ++i) {
      impulse = start;
      result = solver.solve(system, {}, impulse, mode);
    }
    const double us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / batch;
    if (k == 0) first = us;
    least = std::min(least, us);
  }
  out.us.push_back(least);
  out.single_us.push_back(first);
  out.sweeps.push_back(result.sweeps);
  out.converged += result.residual <= kDemanded;
  out.worst = std::max(out.worst, result.residual);
  for (const ContactMode m : mode)
    ++(m == ContactMode::free ? out.open : m == ContactMode::stick ? out.sticks : out.slips);
}

/// A soft block under a paraboloid tool that is touched at fixed places of the tool.
class PressedBlock {
 public:
  PressedBlock() : block_(18, "fem", 0.02) {
    block_.site.reach = 0.085;
    model_ = block_.reduce("condensed");
    dynamics_ = std::make_unique<LocalDynamics>(model_, LocalScheme::implicit_euler, Metric::implicit, kStep);
    const SurfacePatch& patch = model_.patch;
    const auto rows = 3 * patch.num_vertices();
    basis_ = model_.basis.topRows(rows);
    x0_ = model_.x0.head(rows);
    centre_ = block_.site.centre;
  }

  Row run(int contacts, const Friction& friction, int ticks) {
    // At most as many as the surface there has vertices: more have fewer freedoms than rows.
    const double spread = LinearizedBlock::edge * std::sqrt(contacts / (0.8 * M_PI));
    std::vector<Vec3> place;  // sunflower: even over the disk
    for (int i = 0; i < contacts; ++i) {
      const double r = spread * std::sqrt((i + 0.5) / contacts), turn = 2.399963 * i;
      place.push_back({r * std::cos(turn), r * std::sin(turn), 0});
    }
    const double curvature = contacts > 1 ? 3e-3 / (spread * spread) : 0;  // the rim touches at 1.5 mm
    VectorX q = VectorX::Zero(model_.dof()), q_rate = q, v_free = q, v_end = q;
    VectorX impulse = VectorX::Zero(3 * contacts);
    ContactSweeps solver(contacts);
    std::vector<ContactMode> modes(contacts);
    Row out;
    Vec3 tool_before = tool_at(0);
    for (int k = 1; k <= ticks; ++k) {
      const Vec3 tool = tool_at(k * kStep);
      dynamics_->free_motion(q, q_rate, v_free, v_end);
      const VectorX x = x0_ + basis_ * q, u = basis_ * v_free;
      const MatrixX& C = dynamics_->metric().C;
      Tick tick;
      tick.friction.assign(contacts, friction);
      tick.velocity.resize(3 * contacts);
      tick.W.resize(3 * contacts, 3 * contacts);
      std::vector<std::pair<Triangle, Vec3>> point;
      for (int i = 0; i < contacts; ++i) {
        point.push_back(find(tool + place[i]));
        const auto& [t, bary] = point.back();
        const Vec3 slope = curvature * place[i];
        const Vec3 n = Vec3(-slope.x(), -slope.y(), 1).normalized();
        Vec3 at = Vec3::Zero(), moves = Vec3::Zero();
        for (int c = 0; c < 3; ++c) {
          at += bary[c] * node(x, t[c]);
          moves += bary[c] * node(u, t[c]);
        }
        const double height = tool.z() + 0.5 * curvature * place[i].squaredNorm();
        const double gap = (height - at.z() - kStep * moves.z()) * n.z();
        const Vec3 relative = moves - (tool - tool_before) / kStep;
        tick.normal.push_back(n);
        tick.velocity.segment<3>(3 * i) = relative - n.dot(relative) * n - gap / kStep * n;
        for (int j = 0; j <= i; ++j) {
          Mat3 W = Mat3::Zero();
          for (int r = 0; r < 3; ++r)
            for (int s = 0; s < 3; ++s)
              W += bary[r] * point[j].second[s] * C.block<3, 3>(3 * t[r], 3 * point[j].first[s]);
          tick.W.block<3, 3>(3 * i, 3 * j) = W;
          tick.W.block<3, 3>(3 * j, 3 * i) = W.transpose();
        }
      }
      if (k == 1) solver.solve(tick.system(), {}, impulse, modes);
      measure(solver, tick, impulse, out);
      q += kStep * v_free;
      q_rate = v_end;
      for (int i = 0; i < contacts; ++i)
        for (int c = 0; c < 3; ++c) {
          const Vec3 part = point[i].second[c] * impulse.segment<3>(3 * i);
          q += kStep * (dynamics_->metric().Y.middleCols<3>(3 * point[i].first[c]) * part);
          q_rate += dynamics_->end_response().middleCols<3>(3 * point[i].first[c]) * part;
        }
      tool_before = tool;
    }
    return out;
  }

 private:
  static constexpr double kStep = 1e-3;

  Vec3 tool_at(double t) const {
    return {centre_.x() + 0.01 * std::sin(4 * M_PI * t), centre_.y() + 0.004 * std::sin(2 * M_PI * t),
            centre_.z() - 0.002 + 0.001 * std::cos(6 * M_PI * t)};
  }

  /// The surface point above or below p, by its place at rest.
  std::pair<Triangle, Vec3> find(const Vec3& p) const {
    const std::vector<Triangle>& triangles = model_.patch.triangles;
    double best = -1e300;
    std::pair<Triangle, Vec3> out;
    for (const Triangle& t : triangles) {
      const Vec3 a = node(x0_, t[0]), b = node(x0_, t[1]), c = node(x0_, t[2]);
      const double area = (b - a).head<2>().x() * (c - a).y() - (b - a).y() * (c - a).x();
      if (!(area > 0)) continue;
      const double v = ((p - a).x() * (c - a).y() - (p - a).y() * (c - a).x()) / area;
      const double w = ((b - a).x() * (p - a).y() - (b - a).y() * (p - a).x()) / area;
      const double inside = std::min({1 - v - w, v, w});
      if (inside > best) {
        best = inside;
        out = {t, Vec3(1 - v - w, v, w)};
      }
    }
    return out;
  }

  LinearizedBlock block_;
  LocalModel model_;
  std::unique_ptr<LocalDynamics> dynamics_;
  SparseMatrix basis_;
  VectorX x0_;
  Vec3 centre_;
};

Row run_random(int contacts, int ticks) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  const auto any = [&] { return normal(engine); };
  Row out;
  ContactSweeps solver(contacts);
  std::vector<ContactMode> modes(contacts);
  constexpr int kSequence = 50;  // ticks over one body
  for (int k = 0; k < ticks; k += kSequence) {
    const int dofs = 3 * contacts + 6;
    const MatrixX J = MatrixX::NullaryExpr(3 * contacts, dofs, any);
    const VectorX a = VectorX::NullaryExpr(dofs, [&] { return std::pow(10.0, 1.5 * unit(engine) - 1.5); });
    Tick tick;
    tick.W = J * a.asDiagonal() * J.transpose();
    tick.velocity = VectorX::NullaryExpr(3 * contacts, any);
    tick.friction.assign(contacts, Friction{0.5, 0.5});
    for (int i = 0; i < contacts; ++i) {
      tick.normal.push_back((Vec3::UnitZ() + 0.5 * Vec3(2 * unit(engine) - 1, 2 * unit(engine) - 1, 0)).normalized());
      tick.velocity.segment<3>(3 * i) += tick.normal[i];
    }
    const VectorX drift = 0.01 * VectorX::NullaryExpr(3 * contacts, any);
    VectorX impulse = VectorX::Zero(3 * contacts);
    solver.solve(tick.system(), {}, impulse, modes);
    for (int i = 0; i < kSequence; ++i) {
      tick.velocity += drift;
      measure(solver, tick, impulse, out);
    }
  }
  return out;
}

int run(int ticks, const std::string& csv) {
  std::FILE* file = csv.empty() ? nullptr : std::fopen(csv.c_str(), "w");
  if (file)
    std::fprintf(file,
                 "family,contacts,p50_us,p99_us,single_p50_us,sweeps_p50,sweeps_p99,converged,worst,peer_p50_us,peer_"
                 "converged\n");
  std::printf("%-15s %8s %8s %8s %10s %7s %5s %10s %9s %12s  %s\n", "family", "contacts", "p50 us", "p99 us",
              "single p50", "sweeps", "p99", "converged", "residual", "peer p50 us", "open/stick/slip");
  PressedBlock block;
  const auto print = [&](const char* family, int i, const Row& row) {
    std::vector<double> sweeps(row.sweeps.begin(), row.sweeps.end());
    const double n = static_cast<double>(row.us.size()), all = n * kPeer[i].contacts;
    const double p50 = percentile(row.us, 0.5), p99 = percentile(row.us, 0.99), single = percentile(row.single_us, 0.5);
    std::printf("%-15s %8d %8.2f %8.2f %10.2f %7.0f %5.0f %9.2f%% %9.1e %6.1f %5.1f%%  %.0f/%.0f/%.0f%%\n", family,
                kPeer[i].contacts, p50, p99, single, percentile(sweeps, 0.5), percentile(sweeps, 0.99),
                100 * row.converged / n, row.worst, kPeer[i].p50_us, 100 * kPeer[i].converged, 100 * row.open / all,
                100 * row.sticks / all, 100 * row.slips / all);
    std::fflush(stdout);
    if (file)
      std::fprintf(file, "%s,%d,%.4g,%.4g,%.4g,%.0f,%.0f,%.5g,%.3g,%g,%g\n", family, kPeer[i].contacts, p50, p99,
                   single, percentile(sweeps, 0.5), percentile(sweeps, 0.99), row.converged / n, row.worst,
                   kPeer[i].p50_us, kPeer[i].converged);
  };
  for (int i = 0; i < static_cast<int>(std::size(kPeer)); ++i) {
    const int c = kPeer[i].contacts;
    print("body, one mu", i, block.run(c, {0.5, 0.5}, ticks));
    print("body, two mu", i, block.run(c, {0.6, 0.4}, ticks));
    print("random", i, run_random(c, ticks));
  }
  if (file) std::fclose(file);
  return 0;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  int ticks = 500;
  std::string csv;
  CLI::App app;
  app.add_option("--ticks", ticks);
  app.add_option("--csv", csv);
  CLI11_PARSE(app, argc, argv);
  return kt::run(ticks, csv);
}
