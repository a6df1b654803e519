#include "haptics/session/body_film.hpp"

#include <algorithm>

namespace kt {

BodyFilm::BodyFilm(const Mesh& mesh, std::size_t most_bytes) {
  std::vector<char> is_surface(static_cast<std::size_t>(mesh.num_nodes()), 0);
  for (const Triangle& t : mesh.triangles)
    for (const int i : t) is_surface[i] = 1;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (is_surface[i]) nodes_.push_back(i);
  most_frames_ = std::max<std::size_t>(2, most_bytes / (6 * std::max<std::size_t>(1, nodes_.size())));
}

bool BodyFilm::is_due(double t, bool is_refreshed) const {
  constexpr double kRoundoff = 1e-9;  // [s]
  return t_.empty() || t - t_.back() > (is_refreshed ? 0.5 : 1.0) * interval_ - kRoundoff;
}

void BodyFilm::add(double t, const VectorX& x) {
  if (t_.size() >= most_frames_) {
    for (std::size_t i = 0; 2 * i < t_.size(); ++i) {
      t_[i] = t_[2 * i];
      if (i > 0) x_[i] = std::move(x_[2 * i]);
    }
    t_.resize((t_.size() + 1) / 2);
    x_.resize(t_.size());
    interval_ *= 2;
    if (!is_due(t, true)) return;
  }
  t_.push_back(t);
  std::vector<float>& out = x_.emplace_back();
  out.reserve(3 * nodes_.size());
  for (const int i : nodes_)
    for (int c = 0; c < 3; ++c) out.push_back(static_cast<float>(node(x, i)[c]));
}

}  // namespace kt
