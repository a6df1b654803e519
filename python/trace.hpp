#pragma once
#include "haptics/session/session.hpp"
#include "python/bindings.hpp"

namespace kt {

/// What a run left.
struct RunTrace {
  SessionResult result;
  std::shared_ptr<Session> session;
  std::string summary;  ///< JSON
  bool has_own_body = false;
  int generation = 0;  ///< of the session's runs
  std::shared_ptr<int> newest;
};

/// Of one tool of a run.
struct Trace {
  std::shared_ptr<RunTrace> run;
  std::size_t tool = 0;
};

void bind_trace(py::module_& m);

/// trace.csv, summary.json, session.json and so on into a folder. Throws InputError.
void save(const Trace& trace, const py::object& folder);

}  // namespace kt

KT_MADE_ONLY(kt::Trace);
