// A process module in C++: the camera over a belt's light barrier. Every period it takes an image and finds
// the parts in it. There is no real camera, so the module renders the image from the parts on the belt. When
// the belt holds a part at the barrier, the module publishes the part's number, kind, position and angle.
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

TAKT_TEXT("A camera over a belt: finds the part at the light barrier and publishes its position and angle.");

namespace {

takt::Property<double> noise{
    "noise",
    6,
    {.min = 0, .max = 60, .text = "Standard deviation of a pixel's brightness (full scale 255)."}};
takt::Property<double> light{
    "light", 30, {.min = 0, .max = 100, .text = "Brightness difference between opposite corners."}};
takt::Property<double> contrast{
    "contrast",
    50,
    {.min = 10, .max = 200, .text = "Minimum brightness difference between a part and the belt."}};
takt::Property<double> repeat{"repeat",
                              2,
                              {.unit = "s",
                               .min = 0.1,
                               .max = 3600,
                               .text = "Time after which a part that still waits is published again."}};
takt::Property<std::int64_t> seed{"seed", 1, {.min = 0, .text = "Seed of the random noise."}};

takt::InPort<line::Scene> scene{"scene", {.text = "The scene in front of the camera."}};
takt::InPort<line::BeltState> belt{"belt", {.text = "State of the belt."}};
takt::OutPort<line::Scene> seen{"seen", {.text = "Every part in the last image."}};
takt::OutPort<line::Part> part{"part", {.text = "The part that waits at the light barrier."}};

/// The body passes a Shutter to the image thread and gets a Sight (the parts in the image) back. Image
/// processing allocates memory and takes milliseconds, so it cannot run in the real-time body.
struct Shutter {
  std::uint32_t waiting = 0;  ///< number of the part that the belt holds; 0: none
  double position = 0;        ///< m, position of the belt
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
std::uint64_t images_taken = 0;
std::uint64_t published = 0;
std::uint64_t not_found = 0;  // images that show no part at the barrier although the belt holds one

void print_summary() {
  std::printf("part_finder: %llu images, %llu parts published, %llu images without the waiting part\n",
              static_cast<unsigned long long>(images_taken), static_cast<unsigned long long>(published),
              static_cast<unsigned long long>(not_found));
}

void process_images(vision::Camera::Settings camera_settings, vision::FinderSettings finder_settings) {
  cv::setNumThreads(1);  // use only one CPU of the device
  vision::Camera camera{camera_settings};
  while (true) {
    while (!shutter.take()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
    const Shutter& now = shutter.taken();
    const cv::Mat image = camera.take(std::span{now.parts.data(), now.count}, now.position);
    const std::vector<vision::PlacedPart> found = vision::find_parts(image, finder_settings);
    Sight& result = sight.writing();
    result.of = now;
    result.count = std::min(found.size(), result.parts.size());
    std::copy_n(found.begin(), result.count, result.parts.begin());
    sight.publish();
  }
}

void take_image() {
  ++images_taken;
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

line::Part to_part(const vision::PlacedPart& found, std::uint32_t number) {
  line::Part result;
  result.number(number);
  result.kind(found.kind == vision::Kind::box ? "box" : "bottle");
  result.x(found.x);
  result.y(found.y);
  result.angle(found.angle);
  return result;
}

/// Returns the part nearest to the barrier if it can be the part that the belt holds, else null.
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
  std::atexit(print_summary);
  const vision::Camera::Settings camera{
      .noise = noise, .light = light, .seed = static_cast<std::uint64_t>(seed.value())};
  // This thread runs until the process ends.
  std::thread{process_images, camera, vision::FinderSettings{.contrast = contrast}}.detach();
  std::uint32_t number = 0;  // number of the part that was published last
  double waited = 0;         // s, since the last publication
  line::Scene all;
  all.parts().reserve(line::MAX_PARTS);

  while (true) {
    waitPeriod();
    scene.read();
    belt.read();
    waited += static_cast<double>(takt_period_ns()) * 1e-9;
    if (scene.has_value()) take_image();
    if (!sight.take()) continue;

    const Sight& now = sight.taken();
    all.position(now.of.position);
    all.parts().clear();
    for (std::size_t i = 0; i < now.count; ++i)
      all.parts().push_back(to_part(now.parts[i], static_cast<std::uint32_t>(i + 1)));
    seen.write(all);

    // The number of the waiting part comes from the belt; its pose comes from the image.
    if (now.of.waiting == 0) continue;
    if (now.of.waiting == number && waited < repeat) continue;
    const vision::PlacedPart* waiting = at_the_barrier(now);
    if (waiting == nullptr) {
      ++not_found;
      continue;
    }
    number = now.of.waiting;
    waited = 0;
    ++published;
    part.write(to_part(*waiting, number));
  }
}
