#include "core/base/finding.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"

namespace kt {

Cure set_to(const std::string& key, const std::string& value, const std::string& price) {
  return {key, value, text("set ", key, " to ", value, price.empty() ? "" : " (" + price + ")")};
}

Cure advise(const std::string& told) { return {"", "", told}; }

std::string alternatives(const std::vector<Cure>& cures) {
  std::string out;
  for (const Cure& cure : cures) out += (out.empty() ? "" : ", or ") + cure.told;
  return out;
}

Finding Finding::at(std::string key, std::optional<double> found, std::optional<double> until) && {
  where = std::move(key);
  value = found;
  limit = until;
  return std::move(*this);
}

std::string Finding::line() const { return cures.empty() ? what : what + "; " + alternatives(cures); }

std::vector<std::string> lines(const std::vector<Finding>& findings) {
  std::vector<std::string> out;
  std::ranges::transform(findings, std::back_inserter(out), &Finding::line);
  return out;
}

}  // namespace kt
