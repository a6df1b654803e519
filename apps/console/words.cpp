#include "apps/console/words.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "core/base/error.hpp"
#include "io/files/file_claim.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

int json_output = STDOUT_FILENO;
bool quiet = false;

/// Words go to another file from here on, in this program and in those that it starts.
void send_words_to(int file) {
  if (json_output == STDOUT_FILENO) json_output = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  dup2(file, STDOUT_FILENO);
}

void send_words_nowhere() {
  quiet = true;
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  send_words_to(nowhere);
  close(nowhere);
}

}  // namespace

bool is_quiet() { return quiet; }

void add_quiet_option(CLI::App& command) {
  command.add_flag_callback("-q,--quiet", send_words_nowhere, "no words on standard output, no progress");
}

void claim_output(const std::string& file, const std::string& option) {
  require_writable(file);
  static std::vector<FileClaim> claims;
  claims.emplace_back(file, option + " " + file);
}

CLI::Option* add_json_option(CLI::App& command, std::string& file, const std::string& what) {
  return command.add_option("--json", file, "also write " + what + " to this file (- for standard output)")
      ->each([](const std::string& name) {
        if (name == "-" && !quiet) send_words_to(STDERR_FILENO);
        claim_output(name, "--json");
      });
}

void write_json(const std::string& file, const std::string& content) {
  if (file.empty()) return;
  if (file != "-") return write_named_file(file, content);
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t n = write(json_output, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw RunError(text("--json -: standard output cannot be written: ", std::strerror(errno)));
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace kt
