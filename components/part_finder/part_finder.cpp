// A process module in C++: the camera over a belt's light barrier. Every period it takes a picture (which it
// renders from what lies on the belt, for there is no camera) and finds the parts in it. When the belt holds
// a part at the barrier, it says which, where, and how it lies.
#include <takt/process.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <thread>
#include <vector>

#include <line.hpp>

#include "../common/latest.hpp"
#include "camera.hpp"
#include "finder.hpp"

TAKT_TEXT("A camera over a belt: says where a part lies that waits at the light barrier.");

namespace {

takt::Property<double> noise{
    "noise", 6, {.min = 0, .max = 60, .text = "Standard deviation of a pixel's brightness, of 255."}};
takt::Property<double> light{
    "light", 30, {.min = 0, .max = 100, .text = "How much brighter one corner is than the opposite one."}};
takt::Property<double> contrast{
    "contrast", 50, {.min = 10, .max = 200, .text = "How much brighter than the belt a part is at least."}};
takt::Property<double> repeat{
    "repeat",
    2,
    {.unit = "s", .min = 0.1, .max = 3600, .text = "Until a part that still waits is told again."}};
takt::Property<std::int64_t> seed{"seed", 1, {.min = 0, .text = "Of the noise."}};

takt::InPort<line::Scene> scene{"scene", {.text = "What lies before the camera."}};
takt::InPort<line::BeltState> belt{"belt", {.text = "What the belt does."}};
takt::OutPort<line::Scene> seen{"seen", {.text = "The parts in the last picture."}};
takt::OutPort<line::Part> part{"part", {.text = "A part waits at the light barrier."}};

/// What the body gives to the thread that looks, and gets back: looking allocates and takes milliseconds, and
/// a body is released on time.
struct Shutter {
  std::uint32_t waiting = 0;  ///< the number of the part that the belt holds; 0: none
  double position = 0;        ///< m, of the belt
  std::array<vision::PlacedPart, line::MAX_PARTS> parts{};
  std::size_t count = 0;
};
struct Sight {
  Shutter of{};
  std::array<vision::PlacedPart, line::MAX_PARTS> parts{};
  std::size_t count = 0;
};
Latest<Shutter> shutter;
Latest<Sight> sight;
std::uint64_t pictures = 0;
std::uint64_t told = 0;
std::uint64_t searched = 0;  // pictures in which a part should have been at the barrier, and was not found

void say_goodbye() {
  std::printf("part_finder: %llu pictures, %llu parts told, %llu searched in vain\n",
              static_cast<unsigned long long>(pictures), static_cast<unsigned long long>(told),
              static_cast<unsigned long long>(searched));
}

void look(vision::Camera::Settings camera_settings, vision::FinderSettings finder_settings) {
  cv::setNumThreads(1);  // the device's other processors are not ours
  vision::Camera camera{camera_settings};
  while (true) {
    while (!shutter.take()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
    const Shutter& now = shutter.taken();
    const cv::Mat picture = camera.take(std::span{now.parts.data(), now.count}, now.position);
    const std::vector<vision::PlacedPart> found = vision::find_parts(picture, finder_settings);
    Sight& result = sight.writing();
    result.of = now;
    result.count = std::min(found.size(), result.parts.size());
    std::copy_n(found.begin(), result.count, result.parts.begin());
    sight.publish();
  }
}

void press() {
  ++pictures;
  Shutter& next = shutter.writing();
  next.waiting = belt.value().mode() == line::BELT_HOLDING ? belt.value().parts() : 0;
  next.position = scene.value().position();
  next.count = 0;
  for (const line::Part& one : scene.value().parts()) {
    next.parts[next.count++] = {.kind = one.kind() == "bottle" ? vision::Kind::bottle : vision::Kind::box,
                                .x = one.x(),
                                .y = one.y(),
                                .angle = one.angle()};
  }
  shutter.publish();
}

line::Part told_of(const vision::PlacedPart& found, std::uint32_t number) {
  line::Part result;
  result.number(number);
  result.kind(found.kind == vision::Kind::box ? "box" : "bottle");
  result.x(found.x);
  result.y(found.y);
  result.angle(found.angle);
  return result;
}

/// The one nearest to the barrier, and near enough to be what it holds; null: there is none.
const vision::PlacedPart* at_the_barrier(const Sight& now) {
  constexpr double kNear = 0.05;  // m
  const vision::PlacedPart* nearest = nullptr;
  for (std::size_t i = 0; i < now.count; ++i) {
    const vision::PlacedPart& one = now.parts[i];
    if (std::abs(one.x) > kNear) continue;
    if (nearest == nullptr || std::abs(one.x) < std::abs(nearest->x)) nearest = &one;
  }
  return nearest;
}

}  // namespace

int main() {
  initPeriodExe();
  std::atexit(say_goodbye);
  const vision::Camera::Settings camera{
      .noise = noise, .light = light, .seed = static_cast<std::uint64_t>(seed.value())};
  std::thread{look, camera, vision::FinderSettings{.contrast = contrast}}.detach();  // until the program ends
  std::uint32_t number = 0;  // of the part that was told last
  double waited = 0;         // s, since then
  line::Scene all;
  all.parts().reserve(line::MAX_PARTS);

  while (true) {
    waitPeriod();
    scene.read();
    belt.read();
    waited += static_cast<double>(takt_period_ns()) * 1e-9;
    if (scene.has_value()) press();
    if (!sight.take()) continue;

    const Sight& now = sight.taken();
    all.position(now.of.position);
    all.parts().clear();
    for (std::size_t i = 0; i < now.count; ++i)
      all.parts().push_back(told_of(now.parts[i], static_cast<std::uint32_t>(i + 1)));
    seen.write(all);

    // The part that the barrier counted last is the one that waits there; the picture says where.
    if (now.of.waiting == 0) continue;
    if (now.of.waiting == number && waited < repeat) continue;
    const vision::PlacedPart* waiting = at_the_barrier(now);
    if (waiting == nullptr) {
      ++searched;
      continue;
    }
    number = now.of.waiting;
    waited = 0;
    ++told;
    part.write(told_of(*waiting, number));
  }
}
