#include "watch/view.hpp"

#include <algorithm>

#include <takt/os/keyboard.hpp>

namespace takt::tool::watch {

namespace {

using Keyboard = os::Keyboard;

constexpr std::size_t kLongestFilter = 60;

std::optional<Verb> verb_of(int key) {
  switch (key) {
    case 'i':
      return Verb::initialize;
    case 's':
      return Verb::start;
    case 't':
      return Verb::stop;
    case 'r':
      return Verb::recover;
    case 'x':
      return Verb::reset;
    case 'R':
      return Verb::restart;
    case 'D':
      return Verb::destruct;
    default:
      return std::nullopt;
  }
}

/// The number of rows by which a key moves the selection, if `room` rows fit on the screen. None for a key
/// that does not move the selection.
std::optional<std::ptrdiff_t> steps_of(int key, std::size_t room) {
  const auto page = static_cast<std::ptrdiff_t>(std::max<std::size_t>(room, 2) - 1);
  constexpr std::ptrdiff_t kAll = 1'000'000'000;
  switch (key) {
    case Keyboard::kUp:
    case 'k':
      return -1;
    case Keyboard::kDown:
    case 'j':
      return 1;
    case Keyboard::kPageUp:
      return -page;
    case Keyboard::kPageDown:
    case ' ':
      return page;
    case Keyboard::kHome:
    case 'g':
      return -kAll;
    case Keyboard::kEnd:
    case 'G':
      return kAll;
    default:
      return std::nullopt;
  }
}

std::size_t moved(std::size_t at, std::ptrdiff_t steps, std::size_t last) {
  const auto to = static_cast<std::ptrdiff_t>(at) + steps;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(to, 0, static_cast<std::ptrdiff_t>(last)));
}

void choose(View& view, std::ptrdiff_t steps, const Shown& shown) {
  if (shown.targets.empty()) return;
  view.chosen_at = moved(view.chosen_at, steps, shown.targets.size() - 1);
  view.chosen = shown.targets[view.chosen_at];
  view.slipped = false;
}

// Handles a key while the user types the filter. The bytes of a UTF-8 character arrive as one key each.
void type(View& view, int key) {
  if (key == Keyboard::kEscape) view.filter.clear();
  if (key == Keyboard::kEscape || key == '\r' || key == '\n') {
    view.typing = false;
  } else if (key == Keyboard::kBackspace) {
    while (!view.filter.empty() && (static_cast<unsigned char>(view.filter.back()) & 0xc0U) == 0x80U)
      view.filter.pop_back();
    if (!view.filter.empty()) view.filter.pop_back();
  } else if (key >= ' ' && key < 256 && view.filter.size() < kLongestFilter) {
    view.filter += static_cast<char>(key);
  }
}

void sort_by_neighbour(View& view, int key) {
  const auto at = static_cast<std::size_t>(view.column);
  view.column = static_cast<Column>((at + (key == '>' ? 1 : kColumns - 1)) % kColumns);
  view.reversed = false;
}

void open_page(View& view, Page page) {
  view.page = page;
  view.scroll = 0;
}

void leave(View& view) {
  if (view.page != Page::list)
    open_page(view, Page::list);
  else
    view.filter.clear();
}

// Moves the selection if the page is the list, and scrolls any other page.
void move(View& view, std::ptrdiff_t steps, const Shown& shown) {
  if (view.page == Page::list)
    choose(view, steps, shown);
  else
    view.scroll = moved(view.scroll, steps, shown.length - std::min(shown.room, shown.length));
}

}  // namespace

const char* to_text(Verb verb) {
  switch (verb) {
    case Verb::initialize:
      return "initialize";
    case Verb::start:
      return "start";
    case Verb::stop:
      return "stop";
    case Verb::recover:
      return "recover";
    case Verb::reset:
      return "reset";
    case Verb::restart:
      return "restart";
    case Verb::destruct:
      return "destruct";
  }
  return "?";
}

void settle(View& view, const Shown& shown) {
  const std::size_t rows = shown.targets.size();
  if (!view.pressed && rows > 0) view.chosen = shown.targets.front();
  const bool stays = view.chosen_at < rows && shown.targets[view.chosen_at] == view.chosen;
  const auto found = std::find(shown.targets.begin(), shown.targets.end(), view.chosen);
  if (stays) {  // no search: two nodes with the same name have rows with the same target
  } else if (found != shown.targets.end()) {
    view.chosen_at = static_cast<std::size_t>(found - shown.targets.begin());
  } else if (view.page == Page::list) {  // the details page keeps its target even if its row disappears
    view.chosen_at = rows == 0 ? 0 : std::min(view.chosen_at, rows - 1);
    view.chosen = rows == 0 ? "" : shown.targets[view.chosen_at];
    view.slipped = view.pressed;
  }
  const std::size_t room = std::max<std::size_t>(shown.room, 1);
  view.first = std::min(view.first, rows - std::min(room, rows));
  if (view.chosen_at < view.first) view.first = view.chosen_at;
  if (view.chosen_at >= view.first + room) view.first = view.chosen_at - room + 1;
  if (view.page != Page::list)
    view.scroll = std::min(view.scroll, shown.length - std::min(room, shown.length));
}

Done press(View& view, int key, const Shown& shown) {
  view.pressed = true;
  if (view.typing) {
    type(view, key);
    return {};
  }
  view.message.clear();
  if (view.asked) {  // the user was asked to confirm a command; only y confirms it
    const Command command = *view.asked;
    view.asked.reset();
    if (key == 'y' || key == 'Y') {
      view.slipped = false;
      return {.command = command};
    }
    view.message = std::string{to_text(command.verb)} + " of " + command.target + " cancelled";
    return {};
  }
  if (const auto steps = steps_of(key, shown.room)) {
    move(view, *steps, shown);
    return {};
  }
  const bool modules = view.page == Page::list || view.page == Page::details;
  if (const auto verb = verb_of(key); verb && modules && !view.chosen.empty()) {
    if (*verb == Verb::restart && view.chosen.find('.') == std::string::npos) {
      view.message = "select a module to restart it";
      return {};
    }
    // A command that makes a module begin or end must be confirmed, because a machine may move.
    const bool is_harmless = *verb == Verb::recover || *verb == Verb::initialize;
    if (is_harmless && !view.slipped) return {.command = Command{*verb, view.chosen}};
    view.asked = Command{*verb, view.chosen};
    return {};
  }
  switch (key) {
    case 'q':
      return {.quit = true};
    case '\r':
    case '\n':
      if (view.page == Page::list && !view.chosen.empty()) {
        open_page(view, Page::details);
        view.slipped = false;
      }
      break;
    case Keyboard::kEscape:
    case Keyboard::kBackspace:
      leave(view);
      break;
    case '?':
    case 'h':
      open_page(view, view.page == Page::help ? Page::list : Page::help);
      break;
    case 'c':
      open_page(view, view.page == Page::connections ? Page::list : Page::connections);
      break;
    case 'n':
    case 'p':
      if (view.page != Page::details) break;
      choose(view, key == 'n' ? 1 : -1, shown);
      view.scroll = 0;
      break;
    case '/':
      view.typing = view.page == Page::list || view.page == Page::connections;
      break;
    case '<':
    case '>':
      if (view.page == Page::list) sort_by_neighbour(view, key);
      break;
    case 'v':
      if (view.page == Page::list) view.reversed = !view.reversed;
      break;
    default:
      break;
  }
  return {};
}

}  // namespace takt::tool::watch
