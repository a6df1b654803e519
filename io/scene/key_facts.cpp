#include "io/scene/key_facts.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/ranges.hpp"

namespace kt {
namespace {

struct AnyVisitor {
  template <class... Field>
  void operator()(const char*, Field&&...) {}
};
template <class T>
concept Group = requires(AnyVisitor a, T group) {
  fields(a, group);
};
template <class T>
concept Number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

std::string below(const std::string& group, const char* key) { return group.empty() ? key : group + "." + key; }

class LimitCheck {
 public:
  explicit LimitCheck(std::string group) : group_(std::move(group)) {}
  template <class T>
  void operator()(const char* key, T& value, const KeyFacts& facts = {}) const {
    check(below(group_, key), value, facts);
  }
  template <class T>
  static void check(const std::string& key, T& value, const KeyFacts& facts) {
    if constexpr (Group<T>) {
      LimitCheck inner(key);
      fields(inner, value);
    } else if constexpr (Number<T>) {
      require_within({{.key = key,
                       .value = static_cast<double>(value),
                       .least = facts.least,
                       .most = facts.most,
                       .above = facts.above,
                       .below = facts.below}});
    }
  }
  template <class T>
  static void check(const std::string& key, std::optional<T>& value, const KeyFacts& facts) {
    if (value) check(key, *value, facts);
  }
  template <class T>
  static void check(const std::string& key, std::vector<T>& list, const KeyFacts& facts) {
    for (std::size_t i = 0; i < list.size(); ++i) check(text(key, "[", i, "]"), list[i], facts);
  }

 private:
  std::string group_;
};

template <Group T>
void require_limits_of(const std::string& group, T settings) {
  LimitCheck::check(group, settings, {});
}

class Finder {
 public:
  explicit Finder(std::string wanted, std::string group = "") : wanted_(std::move(wanted)), group_(std::move(group)) {}
  template <class T>
  void operator()(const char* key, T& value, const KeyFacts& facts = {}) {
    const std::string whole = below(group_, key);
    if (whole == wanted_) found = facts;
    if (wanted_.starts_with(whole + ".")) look_into(whole, value);
  }
  std::optional<KeyFacts> found;

 private:
  template <class T>
  void look_into(const std::string& group, T& value) {
    if constexpr (Group<T>) {
      Finder inner(wanted_, group);
      fields(inner, value);
      found = inner.found;
    }
  }
  template <class T>
  void look_into(const std::string& group, std::optional<T>&) {
    T unset{};
    look_into(group, unset);
  }
  std::string wanted_, group_;
};

/// With as many digits as tell it from any other number; -0 is 0.
template <Number T>
std::string shown(T value) {
  std::array<char, 32> room;
  return {room.data(), std::to_chars(room.data(), room.data() + room.size(), static_cast<T>(value + T{})).ptr};
}
std::string shown(const std::string& value) { return value; }
std::string shown(bool value) { return value ? "true" : "false"; }
std::string shown(const Vec3& v) { return text('[', shown(v.x()), ", ", shown(v.y()), ", ", shown(v.z()), ']'); }

template <class T>
concept Single = Number<T> || std::is_same_v<T, std::string> || std::is_same_v<T, bool> || std::is_same_v<T, Vec3>;

/// All single values of a scene, and what reads them.
class Values {
 public:
  struct Value {
    std::string key, value, chooser;
    std::vector<std::string> would_be;  // words of the chooser
  };
  explicit Values(std::string group = "") : group_(std::move(group)) {}
  template <class T>
  void operator()(const char* key, T& value, const KeyFacts& facts = {}) {
    if constexpr (Single<T>)
      add(key, shown(value), facts.read_by);
    else if constexpr (Group<T>)
      look_into(key, value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value, const KeyFacts& facts = {}) {
    if constexpr (Single<T>) {
      add(key, value ? shown(*value) : "none", facts.read_by);
    } else if constexpr (Group<T>) {
      if (value) look_into(key, *value);
    }
  }
  std::vector<Value> list;

 private:
  template <class T>
  void look_into(const char* key, T& group) {
    Values inner(below(group_, key));
    fields(inner, group);
    std::ranges::move(inner.list, std::back_inserter(list));
  }
  void add(const char* key, std::string value, const ReadBy& by) {
    Value& out = list.emplace_back(below(group_, key), std::move(value));
    if (!by.key) return;
    out.chooser = std::string(by.key).find('.') == std::string::npos ? below(group_, by.key) : by.key;
    for (const char* word : by.words)
      if (word) out.would_be.emplace_back(word);
  }
  std::string group_;
};

std::vector<Values::Value> values_of(Scene scene) {
  Values out;
  fields(out, scene);
  return std::move(out.list);
}

std::map<std::string, std::string> by_key(const std::vector<Values::Value>& values) {
  std::map<std::string, std::string> out;
  for (const Values::Value& v : values) out[v.key] = v.value;
  return out;
}

}  // namespace

void require_limits(const std::string& group, const SceneObject& settings) { require_limits_of(group, settings); }
void require_limits(const std::string& group, const ContactSettings& settings) { require_limits_of(group, settings); }
void require_limits(const std::string& group, const GlobalSettings& settings) { require_limits_of(group, settings); }
void require_limits(const std::string& group, const LocalSettings& settings) { require_limits_of(group, settings); }
void require_limits(const std::string& group, const LinkSettings& settings) { require_limits_of(group, settings); }

KeyFacts facts_of(const std::string& key) {
  Scene scene;
  Finder finder(key);
  fields(finder, scene);
  if (!finder.found) throw std::out_of_range(key + " is no key of a scene");
  return *finder.found;
}

std::vector<UnreadKey> unread_keys(const Scene& scene) {
  Scene standard;
  standard.second_tool.emplace();
  const std::vector<Values::Value> values = values_of(scene);
  const auto now = by_key(values), before = by_key(values_of(standard));
  std::vector<UnreadKey> out;
  for (const Values::Value& v : values) {
    if (v.chooser.empty()) continue;
    const std::string& chosen = now.at(v.chooser);
    const auto usual = before.find(v.key);
    const bool is_changed = usual == before.end() || usual->second != v.value;
    if (is_changed && std::ranges::find(v.would_be, chosen) == v.would_be.end())
      out.push_back({v.key, v.value, v.chooser, chosen, v.would_be});
  }
  return out;
}

}  // namespace kt
