// A thread module in C++: a push button that somebody presses from afar, by its property.
#include <takt/component.hpp>

#include <basic.hpp>

class Button : public takt::Component {
  takt::OutPort<basic::Flag> pressed{
      *this, "pressed", {.text = "Its contact that closes when it is pressed."}};
  takt::OutPort<basic::Flag> closed{*this, "closed", {.text = "Its contact that opens when it is pressed."}};
  takt::Property<bool> down{*this, "down", false, {.text = "Whether it is pressed; takt set does that."}};

  basic::Flag contact_;

  void run(const takt::Cycle&) noexcept override {
    contact_.value(down);
    pressed.write(contact_);
    contact_.value(!down);
    closed.write(contact_);
  }
};
TAKT_COMPONENT(Button, "A push button that is pressed from afar.")
