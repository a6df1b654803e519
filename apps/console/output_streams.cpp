#include "apps/console/output_streams.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <streambuf>
#include <string>

#include "core/base/visible_text.hpp"

namespace kt {
namespace {

/// Hands on what is printed at once, made visible, to a C stream: in order with what printf prints.
class VisibleBuffer : public std::streambuf {
 public:
  explicit VisibleBuffer(std::FILE* to) : to_(to) {}

 protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char one = traits_type::to_char_type(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    const std::string shown = visible_lines({text, static_cast<std::size_t>(size)});
    return std::fwrite(shown.data(), 1, shown.size(), to_) == shown.size() ? size : 0;
  }
  int sync() override { return std::fflush(to_) == 0 ? 0 : -1; }

 private:
  std::FILE* to_;
};

/// A closed descriptor would be the next file's that is opened, and that file then would take what is printed.
void hold_standard_descriptors() {
  for (const int number : {0, 1, 2})
    if (::fcntl(number, F_GETFD) < 0) {
      // The wrong way round, so that its use is an error: printing to a closed output must not look well.
      const int file = ::open("/dev/null", number == 0 ? O_WRONLY : O_RDONLY);
      if (file >= 0 && file != number) ::close(file);
    }
}

}  // namespace

struct OutputStreams::Buffers {
  VisibleBuffer out{stdout}, error{stderr};
  std::streambuf *old_out = nullptr, *old_error = nullptr;
};

OutputStreams::OutputStreams() : buffers_(std::make_unique<Buffers>()) {
  hold_standard_descriptors();
  ::signal(SIGPIPE, SIG_IGN);  // a reader who leaves must not cost the results that are still to be written
  ::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write, and no end on the spot
  buffers_->old_out = std::cout.rdbuf(&buffers_->out);
  buffers_->old_error = std::cerr.rdbuf(&buffers_->error);
}

OutputStreams::~OutputStreams() {
  std::cout.flush();
  std::cerr.flush();
  std::cout.rdbuf(buffers_->old_out);
  std::cerr.rdbuf(buffers_->old_error);
}

bool OutputStreams::finish() {
  errno = 0;
  std::cout.flush();
  const bool good = std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.good();
  if (!good)
    std::cerr << "kilotouch: standard output cannot be written"
              << (errno != 0 ? std::string(": ") + std::strerror(errno) : "") << '\n';
  return good;
}

}  // namespace kt
