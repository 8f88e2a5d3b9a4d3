#include <takt/wire/assembly.hpp>

#include <gtest/gtest.h>


namespace takt::wire::assembly_test {
namespace {

using Commands = Assembly<Command, WholeCommand>;

Command part_of(std::uint32_t part, std::uint32_t parts, std::size_t size = kPart, char byte = 'a') {
  Command command;
  command.part(part);
  command.parts(parts);
  command.data(std::vector<std::uint8_t>(size, static_cast<std::uint8_t>(byte)));
  return command;
}

TEST(Assembly, ReturnsDataOfASinglePartAtOnce) {
  Commands commands;
  WholeCommand whole;
  EXPECT_TRUE(commands.add(part_of(0, 1, 3), "a", whole));
  EXPECT_EQ(whole.data, "aaa");
  EXPECT_TRUE(commands.add(part_of(0, 1, 0), "a", whole));
  EXPECT_EQ(whole.data, "");
}

TEST(Assembly, DoesNotMixPartsWithDifferentKeys) {
  Commands commands;
  WholeCommand whole;
  EXPECT_FALSE(commands.add(part_of(0, 2), "a", whole));
  EXPECT_FALSE(commands.add(part_of(0, 2, kPart, 'b'), "b", whole));
  EXPECT_TRUE(commands.add(part_of(1, 2, 1), "a", whole));
  EXPECT_EQ(whole.data, std::string(kPart + 1, 'a'));
  EXPECT_TRUE(commands.add(part_of(1, 2, 1, 'b'), "b", whole));
  EXPECT_EQ(whole.data, std::string(kPart + 1, 'b'));
  EXPECT_EQ(commands.bytes(), 0U);
}

TEST(Assembly, RejectsPartsWithAnInvalidNumberOrSize) {
  Commands commands;
  WholeCommand whole;
  EXPECT_FALSE(commands.add(part_of(0, 2, kPart - 1), "a", whole)) << "only the last part may be shorter";
  EXPECT_FALSE(commands.add(part_of(0, kMaxData / kPart + 1), "a", whole));
  EXPECT_FALSE(commands.add(part_of(0, 0), "a", whole));
  EXPECT_FALSE(commands.add(part_of(0, 1, kPart + 1), "a", whole));
  EXPECT_EQ(commands.refused(), 4U);
  EXPECT_EQ(commands.bytes(), 0U);
}

TEST(Assembly, RejectsAPartOutOfOrder) {
  Commands commands;
  WholeCommand whole;
  EXPECT_FALSE(commands.add(part_of(1, 2, 1), "a", whole)) << "the first part is missing";
  EXPECT_FALSE(commands.add(part_of(0, 3), "a", whole));
  EXPECT_FALSE(commands.add(part_of(2, 3, 1), "a", whole));
  EXPECT_FALSE(commands.add(part_of(1, 3), "a", whole));
  EXPECT_FALSE(commands.add(part_of(0, 2), "a", whole)) << "part 0 starts again";
  EXPECT_TRUE(commands.add(part_of(1, 2, 0), "a", whole));
  EXPECT_EQ(whole.data.size(), kPart);
}

TEST(Assembly, LimitsTheMemoryForIncompleteData) {
  Commands commands;
  WholeCommand whole;
  constexpr std::uint32_t kParts = kMaxData / kPart;
  for (std::size_t i = 0; i < Commands::kUnfinished; ++i)
    commands.add(part_of(0, kParts), std::to_string(i), whole);
  for (std::uint32_t number = 1; number + 1 < kParts; ++number) {
    const Command part = part_of(number, kParts);
    for (std::size_t i = 0; i < Commands::kUnfinished; ++i) {
      commands.add(part, std::to_string(i), whole);
      ASSERT_LE(commands.bytes(), Commands::kMostBytes);
    }
  }
  EXPECT_FALSE(commands.add(part_of(kParts - 1, kParts, 1), "0", whole)) << "the oldest was dropped";
  EXPECT_TRUE(commands.add(part_of(kParts - 1, kParts, 1), std::to_string(Commands::kUnfinished - 1), whole));
  EXPECT_EQ(whole.data.size(), kMaxData - kPart + 1);
  for (std::size_t i = 0; i <= Commands::kUnfinished; ++i)
    commands.add(part_of(0, 2), "new" + std::to_string(i), whole);
  EXPECT_FALSE(commands.add(part_of(1, 2, 1), "new0", whole));
  EXPECT_TRUE(commands.add(part_of(1, 2, 1), "new1", whole));
}

}  // namespace
}  // namespace takt::wire::assembly_test
