#include <takt/os/library.hpp>

#include <gmock/gmock.h>

#include <string>

namespace takt::os::library_test {
namespace {

using testing::HasSubstr;
const std::string kPlain = TAKT_TEST_OBJECTS "/plain.so";
const std::string kUnique = TAKT_TEST_OBJECTS "/unique.so";

int count_up(const Library& library) { return reinterpret_cast<int (*)()>(library.own_symbol("count_up"))(); }

TEST(Library, FindsOnlySymbolsThatExist) {
  const auto library = Library::open(kPlain, Library::Globals::shared);
  ASSERT_TRUE(library.ok()) << to_text(library.problems());
  EXPECT_NE(library->own_symbol("count_up"), nullptr);
  EXPECT_EQ(library->own_symbol("count_down"), nullptr);
}

TEST(Library, DoesNotFindFunctionsOfTheCLibrary) {
  const auto library = Library::open(kPlain, Library::Globals::shared);
  ASSERT_TRUE(library.ok());
  EXPECT_EQ(library->own_symbol("error"), nullptr);
  EXPECT_EQ(library->own_symbol("malloc"), nullptr);
}

TEST(Library, HasTheSameGlobalsInEverySharedLoad) {
  const auto first = Library::open(kPlain, Library::Globals::shared);
  const auto second = Library::open(kPlain, Library::Globals::shared);
  const int before = count_up(*first);
  EXPECT_EQ(count_up(*second), before + 1);
}

TEST(Library, HasSeparateGlobalsInEachPrivateLoad) {
  const auto shared = Library::open(kPlain, Library::Globals::shared);
  const auto first = Library::open(kPlain, Library::Globals::own);
  const auto second = Library::open(kPlain, Library::Globals::own);
  ASSERT_TRUE(first.ok()) << to_text(first.problems());
  ASSERT_TRUE(second.ok()) << to_text(second.problems());
  EXPECT_EQ(count_up(*first), 1);
  EXPECT_EQ(count_up(*first), 2);
  EXPECT_EQ(count_up(*second), 1);
  EXPECT_EQ(second->own_symbol("error"), nullptr);
}

TEST(Library, HasFreshGlobalsInEachPrivateLoad) {
  for (int i = 0; i < 20; ++i) {
    auto library = Library::open(kPlain, Library::Globals::own);
    ASSERT_TRUE(library.ok()) << to_text(library.problems());
    EXPECT_EQ(count_up(*library), 1);
    if (i % 2 == 0) library->abandon();  // an abandoned library stays in memory
  }
}

TEST(Library, RejectsAPrivateLoadIfTheLoaderWouldShareVariables) {
#if defined(__clang__)
  GTEST_SKIP() << "this compiler creates no unique symbols";
#endif
  EXPECT_TRUE(Library::open(kUnique, Library::Globals::shared).ok());
  const auto copy = Library::open(kUnique, Library::Globals::own);
  ASSERT_FALSE(copy.ok());
  EXPECT_THAT(copy.problems()[0].what, HasSubstr("shared_count"));
  EXPECT_THAT(copy.problems()[0].fix, HasSubstr("-fno-gnu-unique"));
}

TEST(Library, NamesTheFileThatIsMissing) {
  for (const auto globals : {Library::Globals::shared, Library::Globals::own}) {
    const auto library = Library::open("/nowhere/at.so", globals);
    ASSERT_FALSE(library.ok());
    EXPECT_THAT(library.problems()[0].what, HasSubstr("/nowhere/at.so"));
  }
}

TEST(Library, NamesTheFileThatIsNotALibrary) {
  for (const auto globals : {Library::Globals::shared, Library::Globals::own}) {
    const auto library = Library::open(TAKT_SOURCE_DIR "/CMakeLists.txt", globals);
    ASSERT_FALSE(library.ok());
    EXPECT_THAT(library.problems()[0].what, HasSubstr("CMakeLists.txt"));
  }
}

}  // namespace
}  // namespace takt::os::library_test
