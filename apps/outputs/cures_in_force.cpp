#include "apps/outputs/cures_in_force.hpp"

#include "core/base/error.hpp"

namespace kt {

bool changes(const Scene& scene, const Cure& cure) {
  if (cure.key.empty() || cure.value.empty()) return true;
  const std::string json = to_json(scene);
  try {
    return !(parse_scene(json, {cure.key + '=' + cure.value}) == parse_scene(json));
  } catch (const InputError&) {
    return false;
  }
}

std::vector<Finding> with_true_cures(const Scene& scene, std::vector<Finding> findings) {
  for (Finding& found : findings) std::erase_if(found.cures, [&](const Cure& cure) { return !changes(scene, cure); });
  return findings;
}

}  // namespace kt
