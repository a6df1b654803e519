#pragma once
// Standard output and error of the command: nothing that a file holds can steer the terminal, and what could not be
// written is no success.
#include <memory>

namespace kt {

/// While it lives, std::cout and std::cerr show control characters instead of sending them
/// (core/base/visible_text.hpp). To be made first in main: also keeps descriptors 0 to 2 from files that are opened
/// later, when they are closed.
class OutputStreams {
 public:
  OutputStreams();
  ~OutputStreams();
  OutputStreams(const OutputStreams&) = delete;
  OutputStreams& operator=(const OutputStreams&) = delete;
  /// Whether all that was printed so far has been written; else says so on stderr.
  bool finish();

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace kt
