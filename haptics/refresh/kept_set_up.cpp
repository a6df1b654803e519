#include "haptics/refresh/kept_set_up.hpp"

#include <algorithm>
#include <iterator>

#include "core/body/state.hpp"
#include "core/body/tangent_model.hpp"

namespace kt {
namespace {

void add(StateHash& hash, const SparseMatrix& matrix) {
  const auto entries = static_cast<std::size_t>(matrix.nonZeros());
  hash.add(matrix.outerIndexPtr(), sizeof(int) * static_cast<std::size_t>(matrix.outerSize() + 1));
  hash.add(matrix.innerIndexPtr(), sizeof(int) * entries);
  hash.add(matrix.valuePtr(), sizeof(double) * entries);
}

std::uint64_t hash_of(const TangentModel& tangent) {
  StateHash hash;
  for (const VectorX* v : {&tangent.state.x, &tangent.state.v, &tangent.f0}) hash.add(*v);
  for (const SparseMatrix* m : {&tangent.dfdx, &tangent.dfdv, &tangent.mass}) add(hash, *m);
  for (const int node : tangent.fixed_nodes) hash.add(node);
  return hash.value();
}

void add(std::vector<double>& out, const ContactSite& site) {
  out.insert(out.end(), {site.centre.x(), site.centre.y(), site.centre.z(), site.way.x(), site.way.y(), site.way.z(),
                         site.reach, static_cast<double>(site.triangle), static_cast<double>(site.others.size())});
  for (const ContactSite& other : site.others) add(out, other);
}

void add(std::vector<double>& out, const ReducerNeeds& needs) {
  out.insert(out.end(),
             {needs.tolerance, needs.budget_us, needs.refresh_per_tick, needs.whole ? 1.0 : 0.0,
              needs.refresh_budget_ms, needs.rest_ms, needs.beside_ms, needs.motion ? 1.0 : 0.0, needs.cells_error});
  if (!needs.motion) return;
  out.push_back(needs.motion->total);
  std::ranges::copy(needs.motion->changing, std::back_inserter(out));
}

}  // namespace

SetUpKey set_up_key(const std::string& reducer, int rings, const ReducerNeeds& needs, const ExpectedTouch& touch,
                    const std::optional<Excitation>& excitation, const TangentModel& tangent, const SurfacePatch& patch,
                    const ContactSite& site) {
  SetUpKey out{reducer, {static_cast<double>(rings), patch.is_curved ? 1.0 : 0.0}, patch.global_node, hash_of(tangent)};
  add(out.numbers, needs);
  out.numbers.insert(out.numbers.end(), {touch.places, touch.facets, touch.is_refined ? 1.0 : 0.0,
                                         touch.is_long ? 1.0 : 0.0, touch.is_projected ? 1.0 : 0.0});
  add(out.numbers, site);
  if (excitation) std::ranges::copy(*excitation, std::back_inserter(out.numbers));
  return out;
}

std::shared_ptr<const ReducerSetUp> KeptSetUp::find(const SetUpKey& key) const {
  const std::scoped_lock lock(guard_);
  return found_ && key_ == key ? found_ : nullptr;
}

void KeptSetUp::keep(SetUpKey key, std::shared_ptr<const ReducerSetUp> found) {
  const std::scoped_lock lock(guard_);
  key_ = std::move(key);
  found_ = std::move(found);
}

}  // namespace kt
