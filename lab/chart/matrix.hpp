#pragma once
// What a chart of speed against accuracy runs: bodies, methods, and whose forces are the truth.
#include <string>
#include <vector>

namespace kt {

/// Settings on top of the scene's, as for --set.
struct ChartMethod {
  std::string family;  ///< drawn in one colour
  std::string label;
  std::vector<std::string> set;
  bool is_ours = false;  ///< as the engine chooses by itself: marked in the chart
};

struct ChartBody {
  std::string name;
  std::vector<std::string> set;
};

struct ChartMatrix {
  std::string name;   ///< of its files: letters and underlines
  std::string title;  ///< for readers
  std::string scene;  ///< file
  std::vector<ChartBody> bodies;
  std::vector<ChartMethod> methods;  ///< every one on every body
  /// The truth of all bodies, an own run of the first method; empty: each body's own full nonlinear model in fine
  /// steps.
  std::vector<ChartBody> truth;
};

/// Methods against the full model on the same mesh: two bodies, or with `full` all materials.
ChartMatrix drag_matrix(const std::string& scene, bool full);

/// Bodies and meshes against the continuum: a sphere pressed in; the truth is a finer mesh of 10-node elements.
ChartMatrix press_matrix(const std::string& scene, bool full);

/// The body of a user's scene as it is, with every method.
ChartMatrix scene_matrix(const std::string& scene, bool full);

}  // namespace kt
