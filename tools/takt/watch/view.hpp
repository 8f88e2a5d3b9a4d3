// The view of `takt watch`: which page and row the user has selected, and what each key does.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace takt::tool::watch {

enum class Page { list, details, connections, help };

/// The columns by which the list can be sorted, in the order on the screen.
enum class Column { name, state, p50, p99, budget, overruns, errors, cycles, missed };
inline constexpr std::size_t kColumns = 9;

enum class Verb { initialize, start, stop, recover, reset, restart, destruct };
const char* to_text(Verb verb);

struct Command {
  Verb verb = Verb::start;
  std::string target;  ///< "DEVICE" or "DEVICE.MODULE"
  bool operator==(const Command&) const = default;
};

struct View {
  Page page = Page::list;
  Column column = Column::name;
  bool reversed = false;
  std::string filter{};            ///< the list shows only the rows that contain these words
  bool typing = false;             ///< the user is typing the filter
  bool pressed = false;            ///< the user has pressed a key; until then the first row is selected
  std::string chosen{};            ///< the target of the selected row, which stays selected when rows move
  std::size_t chosen_at = 0;       ///< index of the selected row, or of its successor if the row disappears
  bool slipped = false;            ///< the selection moved by itself, so ask before a command
  std::size_t first = 0;           ///< the first row that is shown
  std::size_t scroll = 0;          ///< the number of lines scrolled off the top of a page other than the list
  std::optional<Command> asked{};  ///< the command that waits for the user's confirmation
  std::string message{};           ///< the result of the last key, for the user
};

/// The properties of the drawn screen that the handling of keys needs.
struct Shown {
  std::vector<std::string> targets;  ///< the targets of all rows, also of those not on the screen
  std::size_t room = 1;              ///< rows that fit on the screen
  std::size_t length = 0;            ///< the number of lines of a page other than the list
};

struct Done {
  bool quit = false;
  std::optional<Command> command{};
};

/// Adapts the view to the rows that exist now. Keeps the selected row; if it has disappeared, selects the row
/// that took its place.
void settle(View& view, const Shown& shown);

/// Handles a key: changes the view, and returns what `takt watch` must do. `key` is a key of os::Keyboard.
Done press(View& view, int key, const Shown& shown);

}  // namespace takt::tool::watch
