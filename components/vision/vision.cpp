// A sporadic process module in the form of the paper's Figure 11. Every `every` releases, it takes an image
// of a part that moves in a circle, and measures the part's position. The module prints the measurement
// errors only at the end, because its body is real-time code.
#include <takt/process.h>

#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "blob.hpp"

TAKT_TEXT("Measures the position of a part in an image.");
TAKT_INTEGER(every, 100, 1, 1000000000, "releases", "Number of releases from one frame to the next.");
TAKT_NUMBER(radius_px, 8, 2, 20, "px", "Radius of the part.");
TAKT_NUMBER(noise, 10, 0, 60, "grey levels", "Amplitude of the noise.");
TAKT_INTEGER(threshold, 100, 1, 254, "grey levels",
             "Brightness threshold between the background (40) and the part (200).");
TAKT_NUMBER(turn_s, 4, 0.1, 3600, "s", "Time in which the part moves once around the circle.");

namespace {

std::uint64_t releases = 0;
std::uint64_t frames = 0;
std::uint64_t lost = 0;
double largest_error = 0;
vision::Spot last{};

void print_summary() {
  std::printf("vision: %llu frames in %llu releases, largest error %.3f px, lost %llu\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(releases),
              largest_error, static_cast<unsigned long long>(lost));
  std::printf("vision: the last part was at (%.2f, %.2f) px\n", last.x, last.y);
}

}  // namespace

int condition() {
  waitSporadic();  // wait for signal
  ++releases;
  if (releases % static_cast<std::uint64_t>(every) == 0)
    return TRUE;  // condition is met.
  else
    return FALSE;  // otherwise
}

int main() {
  initSporadicExe();
  std::atexit(print_summary);
  vision::Frame frame;
  vision::Noise source;

  while (1) {
    if (!condition())  // if not satisfied
      continue;        // enter into waiting state

    const std::int64_t now_ns = takt_release_ns();
    const double angle =
        2 * std::numbers::pi * std::fmod(static_cast<double>(now_ns) * 1e-9, turn_s) / turn_s;
    const vision::Spot part{vision::kWidth / 2.0 + 24 * std::cos(angle),
                            vision::kHeight / 2.0 + 18 * std::sin(angle)};
    vision::render(frame, part, radius_px, noise, source);
    const auto blob = vision::find(frame, static_cast<std::uint8_t>(threshold), 10);
    ++frames;
    if (!blob) {
      ++lost;
      continue;
    }
    const double error = std::hypot(blob->centre.x - part.x, blob->centre.y - part.y);
    largest_error = std::max(largest_error, error);
    last = blob->centre;
  }
  return 0;
}
