#pragma once
// The files of one result: all of them take their places, or none.
#include <deque>
#include <string>
#include <vector>

#include "io/files/output_file.hpp"

namespace kt {

class ResultFiles {
 public:
  /// @param folder  is there
  explicit ResultFiles(std::string folder) : folder_(std::move(folder)) {}
  /// Written to the disk beside its place. @param name  in the folder, or in one inside that is there
  /// @throws InputError naming the file and the reason
  void add(const std::string& name, const Parts& next);
  void add(const std::string& name, const std::string& content);
  /// An earlier result's, which this one does not have.
  void drop(const std::string& name) { dropped_.push_back(folder_ + '/' + name); }
  /// In the places of an earlier result's. What was not committed is gone with this object.
  void commit();

 private:
  std::string folder_;
  std::deque<PendingFile> files_;
  std::vector<std::string> dropped_;
};

}  // namespace kt
