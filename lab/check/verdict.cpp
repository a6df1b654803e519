#include "lab/check/verdict.hpp"

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr const char* kNames[] = {"pass", "degraded", "fail", "skipped"};

int badness(Verdict v) { return v == Verdict::skipped ? 0 : static_cast<int>(v); }

}  // namespace

std::string name_of(Verdict verdict) { return kNames[static_cast<int>(verdict)]; }

Verdict verdict_named(const std::string& name) {
  for (int i = 0; i < 4; ++i)
    if (name == kNames[i]) return static_cast<Verdict>(i);
  throw_unknown("verdict", name, {kNames, kNames + 4});
}

Verdict worse(Verdict a, Verdict b) {
  if (a == Verdict::skipped) return b;
  return b != Verdict::skipped && badness(b) > badness(a) ? b : a;
}

void StageResult::lower(Verdict to, const std::string& reason, const std::optional<Vec3>& at) {
  if (to == Verdict::skipped || badness(to) > badness(verdict)) {
    verdict = to;
    if (at) where = at;
  }
  if (!where && at) where = at;
  why += (why.empty() ? "" : "; ") + reason;
}

nlohmann::ordered_json to_json(const StageResult& stage) {
  nlohmann::ordered_json out{{"name", stage.name}, {"verdict", name_of(stage.verdict)}, {"why", stage.why}};
  if (stage.where) out["where"] = {(*stage.where)[0], (*stage.where)[1], (*stage.where)[2]};
  out["figures"] = stage.figures;
  out["times"] = stage.times;
  return out;
}

}  // namespace kt
