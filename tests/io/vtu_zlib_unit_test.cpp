// Compressed VTU files: meshio's default (base64 in place) and what ParaView writes (appended, several blocks).
#include "io/files/text_reader.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

const char* const kFiles[] = {"meshio_zlib.vtu", "meshio_zlib_wide.vtu", "zlib_raw.vtu", "zlib_base64_big.vtu"};

std::string seed(const std::string& name) { return std::string(KT_SOURCE_DIR "/tests/fuzz/seeds/") + name; }

TEST(Vtu, CompressedArraysAreRead) {
  for (const char* name : kFiles) {
    const Mesh mesh = load_mesh(seed(name));
    EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3, 1, 1, 1.1}})) << name;
    ASSERT_EQ(mesh.tetrahedra.size(), 2u) << name;
    EXPECT_EQ(mesh.tetrahedra[0], (Tetrahedron{0, 1, 2, 3})) << name;
    EXPECT_EQ(mesh.triangles.size(), 6u) << name;
  }
}

TEST(Vtu, CompressedDataThatAreCutOrGarbledAreRefusedInOneLine) {
  const PrivateFolder folder;
  for (const char* name : kFiles) {
    const std::string whole = read_whole_file(seed(name));
    const std::size_t end = whole.rfind('\n', whole.size() - 60);
    for (std::size_t n = 1; n < end; n += 3) {
      const std::string path = write_sample(folder, "a.vtu", whole.substr(0, n));
      const std::string said = input_error(folder, [&] { load_mesh(path); });
      if (n < whole.find("<Cells>")) {
        EXPECT_NE(said, "") << name << n;
      }
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
  }
  // A block that says it becomes two thousand million bytes.
  std::string bomb = read_whole_file(seed("zlib_raw.vtu"));
  bomb.replace(bomb.find("\n_") + 2 + 8, 8, std::string("\0\0\0\x77\0\0\0\0", 8));
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "a.vtu", bomb)); }).find("are possible"),
            std::string::npos);
}

}  // namespace
}  // namespace kt
