// Free dofs, state hashes, error texts: hand values.
#include <gtest/gtest.h>

#include "core/base/backend.hpp"
#include "core/body/state.hpp"
#include "core/linear/free_dofs.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

TEST(FreeDofs, LeaveOutTheFixedNodesAndPutThemBack) {
  const FreeDofs dofs = make_free_dofs(3, {1});
  EXPECT_EQ(dofs.to_all, (std::vector<int>{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ(dofs.to_free, (std::vector<int>{0, 1, 2, -1, -1, -1, 3, 4, 5}));
  const VectorX all = random_vector(9, 1);
  const VectorX free = gather(dofs, all);
  EXPECT_EQ(free, (VectorX(6) << all.head(3), all.tail(3)).finished());
  VectorX out = VectorX::Constant(9, 7);
  scatter(dofs, free, out);
  EXPECT_EQ(out, (VectorX(9) << all.head(3), Vec3::Constant(7), all.tail(3)).finished());
  const MatrixX matrix = random_vector(81, 2).reshaped(9, 9);
  EXPECT_EQ(MatrixX(gather(dofs, SparseMatrix(matrix.sparseView()))), matrix(dofs.to_all, dofs.to_all));
}

TEST(FreeDofs, AreAllOrNoneWhenNothingOrEverythingIsFixed) {
  EXPECT_EQ(make_free_dofs(2, {}).size(), 6);
  EXPECT_EQ(make_free_dofs(2, {0, 1}).size(), 0);
}

TEST(StateHash, IsFnv1aOverTheBytes) {
  EXPECT_EQ(StateHash().value(), 0xcbf29ce484222325ull);
  StateHash a, foobar;
  a.add("a", 1);
  foobar.add("foobar", 6);
  EXPECT_EQ(a.value(), 0xaf63dc4c8601ec8cull);  // Fowler, Noll and Vo's own test vectors
  EXPECT_EQ(foobar.value(), 0x85944171f73967e8ull);
}

TEST(StateHash, ChangesWithEveryBitAndWithTheOrder) {
  StateHash one, two, swapped, minus_zero, zero, parts;
  one.add(VectorX{{1, 2}});
  two.add(VectorX{{1, std::nextafter(2, 3)}});
  swapped.add(VectorX{{2, 1}});
  minus_zero.add(-0.0);
  zero.add(0.0);
  parts.add(1.0);
  parts.add(2.0);
  EXPECT_NE(one.value(), two.value());
  EXPECT_NE(one.value(), swapped.value());
  EXPECT_NE(zero.value(), minus_zero.value());
  EXPECT_EQ(one.value(), parts.value());
}

TEST(ErrorText, JoinsWhatOperatorWrites) {
  EXPECT_EQ(text("a = ", 1.5, ", b = ", 2, '!'), "a = 1.5, b = 2!");
  EXPECT_EQ(join({}), "");
  EXPECT_EQ(join({"wall"}), "wall");
  EXPECT_EQ(join({"wall", "full"}), "wall, full");
}

TEST(NearestName, ForgivesTyposAndNothingElse) {
  const std::vector<std::string> known{"implicit_euler", "symplectic_euler", "wall"};
  EXPECT_EQ(nearest_name("implict_euler", known), "implicit_euler");
  EXPECT_EQ(nearest_name("sympletic", known), "");  // seven letters short: more than half
  EXPECT_EQ(nearest_name("wal", known), "wall");
  EXPECT_EQ(nearest_name("banana", known), "");
  EXPECT_EQ(nearest_name("wall", {}), "");
}

std::string unknown(const std::string& name, const std::vector<BackendInfo>& table) {
  try {
    require_backend("colour", name, table);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(RequireBackend, PassesWhatIsThereAndSaysWhatElseThereIs) {
  const std::vector<BackendInfo> table{{"red", "", true, ""}, {"blue", "", false, "KT_WITH_BLUE"}};
  EXPECT_EQ(unknown("red", table), "");
  EXPECT_EQ(unknown("rad", table), "unknown colour \"rad\": did you mean \"red\"? (known: red, blue)");
  EXPECT_EQ(unknown("", table), "unknown colour \"\" (known: red, blue)");
  EXPECT_EQ(unknown("blue", table), "colour \"blue\" is not in this build: configure with -DKT_WITH_BLUE=ON");
}

}  // namespace
}  // namespace kt
