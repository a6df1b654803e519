#include "python/bindings.hpp"

namespace kt {
namespace {

/// None for an empty text.
py::object word(const std::string& text) { return text.empty() ? py::none() : py::object(py::str(text)); }
py::object number(const std::optional<double>& value) { return value ? py::object(py::float_(*value)) : py::none(); }

}  // namespace

py::list dicts_of(const std::vector<Finding>& findings) {
  constexpr const char* kWeights[] = {"note", "doubt", "failure"};
  py::list out;
  for (const Finding& f : findings) {
    py::list cures;
    for (const Cure& cure : f.cures) {
      py::dict its;
      its["key"] = word(cure.key);
      its["value"] = word(cure.value);
      its["told"] = cure.told;
      cures.append(its);
    }
    py::dict its;
    its["what"] = f.what;
    its["weight"] = kWeights[static_cast<int>(f.weight)];
    its["where"] = word(f.where);
    its["value"] = number(f.value);
    its["limit"] = number(f.limit);
    its["cures"] = cures;
    out.append(its);
  }
  return out;
}

}  // namespace kt
