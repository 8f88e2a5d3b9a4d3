// A thread module in C++: a push button. An operator presses it remotely by setting its property `down`.
#include <takt/component.hpp>

#include <basic.hpp>

class Button : public takt::Component {
  takt::OutPort<basic::Flag> pressed{
      *this, "pressed", {.text = "Normally open contact: true while the button is pressed."}};
  takt::OutPort<basic::Flag> closed{
      *this, "closed", {.text = "Normally closed contact: false while the button is pressed."}};
  takt::Property<bool> down{
      *this, "down", false, {.text = "True: the button is pressed. Set it with takt set."}};

  basic::Flag contact_;

  void run(const takt::Cycle&) noexcept override {
    contact_.value(down);
    pressed.write(contact_);
    contact_.value(!down);
    closed.write(contact_);
  }
};
TAKT_COMPONENT(Button, "A push button that you press with takt set.")
