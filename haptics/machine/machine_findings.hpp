#pragma once
// What stands in the way of ticks on time on this computer: read from the system's files, said for the person who has
// to mend it. Reading and judging are apart: the judgement is a function of texts.
#include <map>
#include <string>
#include <vector>

namespace kt {

/// Path to content. A file that is not there is not in it.
using MachineFiles = std::map<std::string, std::string>;

/// Of Linux: /proc and /sys. No rights are needed; nothing is changed.
MachineFiles read_machine_files();

struct MachineFinding {
  std::string what;   ///< "the processor's clock falls when it has little to do"
  std::string where;  ///< the file that it was read from
  std::string value;  ///< what stands there
  std::string cure;   ///< command or line of a file; empty: none is needed
};

/// Those that can make ticks late, the heaviest first. A file that is missing says nothing, and is no finding.
std::vector<MachineFinding> find_hindrances(const MachineFiles& files);

}  // namespace kt
