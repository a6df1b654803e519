#include "lab/stability/map.hpp"

namespace kt {

void Confusion::add(const Confusion& c) {
  points += c.points;
  failures += c.failures;
  predicted += c.predicted;
  degraded += c.degraded;
  degraded_warned += c.degraded_warned;
  working += c.working;
  false_alarms += c.false_alarms;
}

Confusion count_predictions(const std::vector<MapPoint>& points) {
  Confusion out;
  for (const MapPoint& p : points) {
    ++out.points;
    switch (p.verdict) {
      case MapVerdict::works:
        ++out.working, out.false_alarms += p.predicted_failure;
        break;
      case MapVerdict::degrades:
        ++out.degraded, out.degraded_warned += p.predicted_failure;
        break;
      case MapVerdict::fails:
        ++out.failures, out.predicted += p.predicted_failure;
        break;
    }
  }
  return out;
}

}  // namespace kt
