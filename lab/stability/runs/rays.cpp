#include "lab/stability/runs/rays.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>

namespace kt {
namespace {

void join_boundary(MapBoundary piece, std::vector<MapBoundary>& out) {
  const auto same = std::ranges::find_if(out, [&](const MapBoundary& b) {
    return b.series == piece.series && b.label == piece.label && b.theory == piece.theory;
  });
  if (same == out.end())
    out.push_back(std::move(piece));
  else
    same->points.insert(same->points.end(), piece.points.begin(), piece.points.end());
}

}  // namespace

MapPoint point_at(const std::string& series, double x, double y, const std::optional<Prediction>& foreseen) {
  MapPoint out{.series = series, .x = x, .y = y, .why = {}, .prediction = {}};
  out.predicted_failure = foreseen.has_value();
  if (foreseen) out.prediction = foreseen->message();
  return out;
}

void run_rays(const MapOptions& options, int count, const std::function<RayResult(int)>& ray, StabilityMap& map) {
  std::vector<RayResult> results(static_cast<std::size_t>(count));
  std::atomic<int> next{0};
  std::mutex mutex;  // of what follows
  int done = 0;
  std::exception_ptr error;
  const auto work = [&] {
    for (int i = next++; i < count && !is_stopped(options); i = next++) {
      try {
        results[static_cast<std::size_t>(i)] = ray(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
      const std::scoped_lock lock(mutex);
      if (++done < count && options.progress) options.progress(static_cast<double>(done) / count);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < std::min(options.jobs, count); ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  if (error) std::rethrow_exception(error);
  for (RayResult& r : results) {
    std::ranges::move(r.points, std::back_inserter(map.points));
    for (MapBoundary& b : r.boundaries) join_boundary(std::move(b), map.boundaries);
  }
}

}  // namespace kt
