// Files of every format, cut and with bits and bytes changed: each is a mesh or one line, and takes no more memory than
// the file gives reason for.
#include <sys/resource.h>

#include <fstream>
#include <random>

#include "io/files/text_reader.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

std::string changed(std::string data, std::mt19937& random) {
  const auto at = [&](std::size_t n) { return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1)); };
  switch (random() % 4) {
    case 0:  // cut
      return data.substr(0, 1 + at(data.size()));
    case 1:  // one to four bits
      for (int k = 1 + static_cast<int>(random() % 4); k > 0; --k)
        data[at(data.size())] ^= static_cast<char>(1 << random() % 8);
      return data;
    case 2: {  // a digit, as a wrong count
      const std::size_t digit = data.find_first_of("0123456789", at(data.size()));
      if (digit != std::string::npos) data.insert(digit, std::string(1 + random() % 12, '9'));
      return data;
    }
    default:  // some bytes of 0xFF, as a wrong count of a binary file
      const std::size_t begin = at(data.size());
      for (std::size_t i = begin; i < std::min(begin + 4, data.size()); ++i) data[i] = '\xFF';
      return data;
  }
}

/// Lets this process have so much more memory, as long as it lives.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t more) {
    getrlimit(RLIMIT_AS, &before_);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = pages * 4096 + more;
    setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

TEST(Garbage, IsAMeshOrOneLineInEveryFormat) {
  std::mt19937 random(31);
  const MemoryLimit limit(std::size_t{64} << 20);  // the files have a kilobyte: a count that is believed takes more
  int meshes = 0, refused = 0;
  for (const std::string& file : files_in(KT_SOURCE_DIR "/tests/fuzz/seeds")) {
    const std::string extension = mesh_extension(file);
    if (extension == ".node" || extension == ".ele") continue;
    const std::string good = read_whole_file(file);
    for (int i = 0; i < 400; ++i) {
      const std::string data = changed(good, random);
      try {
        const Mesh mesh =
            load_mesh("a" + extension, {.lenient = i % 2 == 0, .read_file = [&](const std::string&) { return data; }});
        EXPECT_LE(static_cast<std::size_t>(mesh.num_nodes()), 100 * data.size());
        ++meshes;
      } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << file << i;
        EXPECT_LT(std::string(error.what()).size(), 500u) << file << i;
        ++refused;
      }
    }
  }
  EXPECT_GT(meshes, 1000);
  EXPECT_GT(refused, 2000);
}

}  // namespace
}  // namespace kt
