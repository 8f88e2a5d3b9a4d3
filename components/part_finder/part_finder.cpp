// A process module in C++: the camera over a belt's light barrier. Every period it takes a picture (which it
// renders from what lies on the belt, for there is no camera) and finds the parts in it. When the belt holds
// a part at the barrier, it says which, where, and how it lies.
#include <takt/process.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <vector>

#include <line.hpp>

#include "../common/argument.h"
#include "camera.hpp"
#include "finder.hpp"

namespace {

takt::InPort<line::Scene> scene{"scene", {.text = "What lies before the camera."}};
takt::InPort<line::BeltState> belt{"belt", {.text = "What the belt does."}};
takt::OutPort<line::Scene> seen{"seen", {.text = "The parts in the last picture."}};
takt::OutPort<line::Part> part{"part", {.text = "A part waits at the light barrier."}};

std::uint64_t frames = 0;
std::uint64_t told = 0;
std::uint64_t searched = 0;  // pictures in which a part should have been at the barrier, and was not found

void say_goodbye() {
  std::printf("part_finder: %llu pictures, %llu parts told, %llu searched in vain\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(told),
              static_cast<unsigned long long>(searched));
}

const char* name_of(vision::Kind kind) { return kind == vision::Kind::box ? "box" : "bottle"; }

std::vector<vision::PlacedPart> before_the_camera(const line::Scene& now) {
  std::vector<vision::PlacedPart> parts;
  for (const line::Part& one : now.parts()) {
    parts.push_back({.kind = one.kind() == "bottle" ? vision::Kind::bottle : vision::Kind::box,
                     .x = one.x(),
                     .y = one.y(),
                     .angle = one.angle()});
  }
  return parts;
}

line::Part told_of(const vision::PlacedPart& found, std::uint32_t number) {
  line::Part result;
  result.number(number);
  result.kind(name_of(found.kind));
  result.x(found.x);
  result.y(found.y);
  result.angle(found.angle);
  return result;
}

/// The one nearest to the barrier, and near enough to be what it holds; null: there is none.
const vision::PlacedPart* at_the_barrier(const std::vector<vision::PlacedPart>& found) {
  constexpr double kNear = 0.05;  // m
  const vision::PlacedPart* nearest = nullptr;
  for (const vision::PlacedPart& one : found) {
    if (std::abs(one.x) > kNear) continue;
    if (nearest == nullptr || std::abs(one.x) < std::abs(nearest->x)) nearest = &one;
  }
  return nearest;
}

}  // namespace

int main(int argc, char* argv[]) {
  vision::Camera::Settings camera_settings;
  camera_settings.noise = argument_number(argc, argv, "noise", 6, 0, 60);
  camera_settings.light = argument_number(argc, argv, "light", 30, 0, 100);
  camera_settings.seed = static_cast<std::uint64_t>(argument_number(argc, argv, "seed", 1, 0, 1e9));
  vision::FinderSettings finder_settings;
  finder_settings.contrast = argument_number(argc, argv, "contrast", 50, 10, 200);
  const double repeat = argument_number(argc, argv, "repeat", 2, 0.1, 3600);

  cv::setNumThreads(1);  // the device's other processors are not ours
  std::atexit(say_goodbye);
  vision::Camera camera{camera_settings};
  std::uint32_t number = 0;  // of the part that was told last
  double waited = 0;         // s, since then
  line::Scene all;

  initPeriodExe();
  while (true) {
    waitPeriod();
    scene.read();
    belt.read();
    waited += static_cast<double>(takt_period_ns()) * 1e-9;
    if (!scene.has_value()) continue;

    const cv::Mat picture = camera.take(before_the_camera(scene.value()), scene.value().position());
    const std::vector<vision::PlacedPart> found = vision::find_parts(picture, finder_settings);
    ++frames;
    all.position(scene.value().position());
    all.parts().clear();
    for (const vision::PlacedPart& one : found) {
      if (all.parts().size() < line::MAX_PARTS)
        all.parts().push_back(told_of(one, static_cast<std::uint32_t>(all.parts().size() + 1)));
    }
    seen.write(all);

    // The part that the barrier counted last is the one that waits there; the picture says where.
    if (belt.value().mode() != line::BELT_HOLDING) continue;
    if (belt.value().parts() == number && waited < repeat) continue;
    const vision::PlacedPart* waiting = at_the_barrier(found);
    if (waiting == nullptr) {
      ++searched;
      continue;
    }
    number = belt.value().parts();
    waited = 0;
    ++told;
    part.write(told_of(*waiting, number));
  }
}
