#include <progress.hpp>

#include <gmock/gmock.h>

namespace takt::tool {
namespace {


TEST(ShareText, IsABarAndANumber) {
  EXPECT_EQ(share_text(0, "none", {}), "[....................]   0 %  none");
  EXPECT_EQ(share_text(0.42, "4.2 of 10 s", {}), "[########............]  42 %  4.2 of 10 s");
  EXPECT_EQ(share_text(1, "all", {}), "[####################] 100 %  all");
  EXPECT_EQ(share_text(7, "more", {}), "[####################] 100 %  more");
  EXPECT_EQ(share_text(-1, "less", {}), "[....................]   0 %  less");
}

}  // namespace
}  // namespace takt::tool
