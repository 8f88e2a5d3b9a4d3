#include <algorithm>

#include <fmt/format.h>

#include "progress.hpp"
#include "watch/sparkline.hpp"

namespace takt::tool {

std::string share_text(double share, const std::string& of, ScreenStyle style) {
  constexpr std::size_t kBar = 20;
  const double shown = std::clamp(share, 0.0, 1.0);
  return fmt::format("[{}] {:>3.0f} %  {}", watch::bar(shown, kBar, style), shown * 100, of);
}

}  // namespace takt::tool
