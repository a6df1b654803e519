#pragma once
// A command as a shell takes it.
#include <string>
#include <vector>

namespace kt {

/// Words with blanks, quotes or anything else that a shell would read in its own way come in quotes: 'it'\''s.off', and
/// $'b\xff' for what cannot be printed.
std::string shell_words(const std::vector<std::string>& words);

}  // namespace kt
