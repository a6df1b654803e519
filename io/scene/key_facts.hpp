#pragma once
// What is known of each key of a scene: its range, and the settings under which something reads it. All of it comes
// from io/scene/scene.schema.json, by scripts/scene_fields, so that a build without JSON has it too.
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// Another key and its words with which a key is read. No key: whatever the others are.
struct ReadBy {
  const char* key = nullptr;  ///< without a dot: of the same group
  std::array<const char*, 3> words{};
};

struct KeyFacts {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< `least` itself is not allowed
  bool below = false;  ///< `most` itself is not allowed
  ReadBy read_by{};
};

// fields(a, group): calls a(name, field) or a(name, field, KeyFacts) for each key of a group, in the schema's order.
#include "io/scene/scene_fields.inc"

/// Throws InputError for the first number of the group, or of those inside, that is not finite or outside its range.
/// @param group  its key, "contact"
void require_limits(const std::string& group, const SceneObject& settings);
void require_limits(const std::string& group, const ContactSettings& settings);
void require_limits(const std::string& group, const GlobalSettings& settings);
void require_limits(const std::string& group, const LocalSettings& settings);
void require_limits(const std::string& group, const LinkSettings& settings);

/// Of a key of a scene, "contact.mu_static". Throws std::out_of_range where there is none.
KeyFacts facts_of(const std::string& key);

/// A key that was changed and that nothing reads.
struct UnreadKey {
  std::string key, value;
  std::string chooser, chosen;        ///< what keeps it from being read: "tool.shape", "sphere"
  std::vector<std::string> would_be;  ///< with these words it is
};
std::vector<UnreadKey> unread_keys(const Scene& scene);

}  // namespace kt
