#include "station.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <line.hpp>
#include <motion.hpp>

namespace dispatcher {
namespace {

TEST(Pallet, FillsItsPlacesRowByRow) {
  const Pallet pallet{{1, 2, 3}, 3, 2, 0.1};
  EXPECT_NEAR(pallet.slot(0).x, 1, 1e-12);
  EXPECT_NEAR(pallet.slot(2).x, 1.2, 1e-12);
  EXPECT_NEAR(pallet.slot(3).x, 1, 1e-12);
  EXPECT_NEAR(pallet.slot(3).y, 2.1, 1e-12);
  EXPECT_NEAR(pallet.slot(5).y, 2.1, 1e-12);
  EXPECT_NEAR(pallet.slot(6).x, 1, 1e-12);
  EXPECT_NEAR(pallet.slot(6).y, 2, 1e-12);
  EXPECT_EQ(pallet.slot(6).z, 3);
}

line::Part seen(std::uint32_t number, const char* kind, double y) {
  line::Part part;
  part.number(number);
  part.kind(kind);
  part.y(y);
  return part;
}

TEST(Dispatcher, SendsEachPartToTheNextPlace) {
  takt::testing::Module module{{.sporadic = true}};
  auto& part = module.in<line::Part>("part");
  auto& request = module.out<motion::PickRequest>("request");
  ASSERT_TRUE(module.start());
  part.write(seen(1, "box", 0.02));
  EXPECT_EQ(module.step(), 1U);
  ASSERT_EQ(request.count(), 1U);
  const motion::PickRequest first = request.value();
  EXPECT_EQ(first.number(), 1U);
  EXPECT_NEAR(first.pick().x(), 0.77, 1e-12);
  EXPECT_NEAR(first.pick().roll(), std::numbers::pi, 1e-12);

  part.write(seen(1, "box", 0.02));  // the same part, still waiting
  module.step();
  EXPECT_EQ(request.value().place().x(), first.place().x());
  part.write(seen(2, "bottle", -0.01));
  module.step();
  EXPECT_EQ(request.count(), 3U);
  EXPECT_NEAR(request.value().pick().x(), 0.74, 1e-12);
  EXPECT_NEAR(request.value().place().x(), first.place().x() + 0.12, 1e-12);
}

TEST(Dispatcher, TurnsTheToolWithThePart) {
  takt::testing::Module module{{.sporadic = true}};
  auto& part = module.in<line::Part>("part");
  auto& request = module.out<motion::PickRequest>("request");
  ASSERT_TRUE(module.start());
  line::Part turned = seen(1, "box", 0);
  turned.x(0.01);  // the part is not yet at the barrier
  turned.angle(0.4);
  part.write(turned);
  module.step();
  EXPECT_NEAR(request.value().pick().y(), 0.44, 1e-12);
  EXPECT_NEAR(request.value().pick().yaw(), -0.4, 1e-12);
  EXPECT_EQ(request.value().place().yaw(), 0);
  turned.number(2);
  turned.angle(3);  // gives the same axis as -0.14
  part.write(turned);
  module.step();
  EXPECT_NEAR(request.value().pick().yaw(), std::numbers::pi - 3, 1e-12);
}

TEST(Dispatcher, SkipsBottlesIfConfigured) {
  takt::testing::Module module{{.sporadic = true}};
  ASSERT_TRUE(module.set("bottles", "false"));
  auto& part = module.in<line::Part>("part");
  auto& request = module.out<motion::PickRequest>("request");
  ASSERT_TRUE(module.start());
  part.write(seen(1, "bottle", 0));
  module.step();
  EXPECT_EQ(request.count(), 0U);
  part.write(seen(2, "box", 0));
  module.step();
  EXPECT_EQ(request.count(), 1U);
}

}  // namespace
}  // namespace dispatcher
