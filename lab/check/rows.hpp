#pragma once
// From what the workers left to the rows of a report; reports joined, and compared with an older one.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace kt {

/// The row of a report from the row of a batch (io/files/json_batch.hpp): also of a worker that crashed, hung, or took
/// too much memory. Has path, verdict, stage, why, where (the first stage that is as bad as the verdict), triangles,
/// stages, times and, apart from these, outline.
nlohmann::ordered_json report_row(const nlohmann::ordered_json& batch_row);

/// The rows of a batch's file, each as a worker of the check leaves it: what others wrote into it is no surprise later.
/// @throws InputError naming file, line and what is wrong
std::vector<nlohmann::ordered_json> read_check_rows(const std::string& file);

/// An older report.json. @throws InputError for a file that is none
nlohmann::ordered_json read_check_report(const std::string& file);

/// Its worker was ended from outside: that says nothing about the mesh, and it is to be checked again.
bool was_killed(const nlohmann::ordered_json& batch_row);

/// Its worker met the limit of time or memory: with larger ones it may end.
bool met_limit(const nlohmann::ordered_json& batch_row);

/// Rewrites the file of a batch without these rows. @returns how many there were
int forget_rows(const std::string& file, bool (*are_forgotten)(const nlohmann::ordered_json& batch_row));

/// {"kilotouch", "settings", "summary", "times", "rows"}; rows by path, without their outlines.
nlohmann::ordered_json make_report(std::vector<nlohmann::ordered_json> rows, const nlohmann::ordered_json& settings);

/// Paths that fail and did not fail in the baseline (which may lack them), ascending.
std::vector<std::string> new_failures(const nlohmann::ordered_json& report, const nlohmann::ordered_json& baseline);

}  // namespace kt
