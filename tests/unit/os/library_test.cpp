#include <takt/os/library.hpp>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <unistd.h>
#include <folders.hpp>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include <takt/os/sealed_copy.hpp>

namespace takt::os::library_test {
namespace {

using testing::HasSubstr;
const std::string kPlain = build_path("tests/objects/plain.so");
const std::string kUnique = build_path("tests/objects/unique.so");

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

TEST(Library, HasOneCopyOfItsGlobalsIfOpenedWithSharedGlobals) {
  const auto first = Library::open(kPlain, Library::Globals::shared);
  const auto second = Library::open(kPlain, Library::Globals::shared);
  const int before = count_up(*first);
  EXPECT_EQ(count_up(*second), before + 1);
}

TEST(Library, HasSeparateGlobalsInEachInstanceOpenedWithOwnGlobals) {
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

TEST(Library, StartsWithFreshGlobalsEachTimeItIsOpenedWithOwnGlobals) {
  for (int i = 0; i < 20; ++i) {
    auto library = Library::open(kPlain, Library::Globals::own);
    ASSERT_TRUE(library.ok()) << to_text(library.problems());
    EXPECT_EQ(count_up(*library), 1);
    if (i % 2 == 0) library->abandon();  // an abandoned library stays in memory
  }
}

TEST(Library, FindsTheLibrariesBesideItsFile) {
  for (const auto globals : {Library::Globals::own, Library::Globals::shared, Library::Globals::own}) {
    const auto library = Library::open(build_path("tests/objects/needs.so"), globals);
    ASSERT_TRUE(library.ok()) << to_text(library.problems());
    EXPECT_EQ(reinterpret_cast<int (*)()>(library->own_symbol("count_beside"))(), 1)
        << "the library was not unloaded";
  }
}

TEST(Library, DoesNotChangeIfItsFileIsOverwritten) {
  const std::string path = testing::TempDir() + "takt-overwritten-" + std::to_string(::getpid()) + ".so";
  for (const auto globals : {Library::Globals::shared, Library::Globals::own}) {
    std::filesystem::copy_file(kPlain, path, std::filesystem::copy_options::overwrite_existing);
    const auto library = Library::open(path, globals);
    ASSERT_TRUE(library.ok()) << to_text(library.problems());
    std::filesystem::resize_file(path, 0);
    EXPECT_EQ(count_up(*library), 1);
  }
  std::filesystem::remove(path);
}

TEST(Library, CannotBeOpenedIfAPartOfItsFileIsMissing) {
  const std::string path = testing::TempDir() + "takt-part-" + std::to_string(::getpid()) + ".so";
  for (const auto globals : {Library::Globals::shared, Library::Globals::own}) {
    std::filesystem::copy_file(kPlain, path, std::filesystem::copy_options::overwrite_existing);
    for (std::uintmax_t size = std::filesystem::file_size(path); size-- > 0;) {
      if (size > 4096 && size % 4096 != 4095) continue;
      std::filesystem::resize_file(path, size);
      const auto library = Library::open(path, globals);
      ASSERT_FALSE(library.ok()) << size << " bytes";
      EXPECT_THAT(library.problems()[0].what, HasSubstr(path));
    }
  }
  std::filesystem::remove(path);
}

TEST(Library, LoadsTheGivenCopyInsteadOfTheFile) {
  const std::string path = testing::TempDir() + "takt-library-" + std::to_string(::getpid()) + ".so";
  std::filesystem::copy_file(kPlain, path);
  for (const auto globals : {Library::Globals::shared, Library::Globals::own}) {
    auto copy = sealed_copy(path);
    ASSERT_TRUE(copy.ok()) << to_text(copy.problems());
    std::ofstream{path} << "replaced";
    const auto library = Library::open(path, globals, std::move(*copy));
    std::filesystem::copy_file(kPlain, path, std::filesystem::copy_options::overwrite_existing);
    ASSERT_TRUE(library.ok()) << to_text(library.problems());
    EXPECT_EQ(count_up(*library), 1);
  }
  std::filesystem::remove(path);
}

TEST(Library, SharesGlobalsBetweenCopiesOfOneFileOpenedWithSharedGlobals) {
  const std::string one = "/components/one.so";
  const std::string two = "/components/two.so";
  EXPECT_FALSE(Library::is_loaded(one));
  {
    const auto load = [](const std::string& path, Library::Globals globals) {
      return Library::open(path, globals, std::move(*sealed_copy(kPlain)));
    };
    const auto first = load(one, Library::Globals::shared);
    const auto second = load(one, Library::Globals::shared);
    const auto own = load(one, Library::Globals::own);
    const auto other = load(two, Library::Globals::shared);
    EXPECT_TRUE(Library::is_loaded(one));
    EXPECT_EQ(count_up(*first), 1);
    EXPECT_EQ(count_up(*second), 2);
    EXPECT_EQ(count_up(*own), 1);
    EXPECT_EQ(count_up(*other), 1) << "another file";
  }
  EXPECT_FALSE(Library::is_loaded(one));
}

TEST(Library, HasThePathOfItsFile) {
  const std::string relative = std::filesystem::relative(kPlain);
  for (const auto globals : {Library::Globals::shared, Library::Globals::own, Library::Globals::shared}) {
    const auto library = Library::open(relative, globals);
    const auto again = Library::open(relative, globals);
    ASSERT_TRUE(library.ok());
    for (const auto& each : {&library, &again}) {
      Dl_info info{};
      ASSERT_NE(::dladdr((*each)->own_symbol("count_up"), &info), 0);
      EXPECT_TRUE(std::filesystem::path{info.dli_fname}.is_absolute());
      EXPECT_TRUE(std::filesystem::equivalent(info.dli_fname, kPlain)) << info.dli_fname;
    }
  }
}

TEST(Library, CannotBeOpenedWithOwnGlobalsIfTheLoaderWouldShareThem) {
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
    const auto library = Library::open(source_path("CMakeLists.txt"), globals);
    ASSERT_FALSE(library.ok());
    EXPECT_THAT(library.problems()[0].what, HasSubstr("CMakeLists.txt"));
  }
}

}  // namespace
}  // namespace takt::os::library_test
