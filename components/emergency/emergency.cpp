// A sporadic thread module in the form of the paper's Figure 10: switches a motor off when its winding is too
// hot, and on again when it has cooled. With the defaults it trips about three times a second.
#include <takt/module.h>

#include <cstdio>
#include <stdexcept>

#include "limit.hpp"

TAKT_TEXT("Switches a motor off when its winding is too hot, and on again when it has cooled.");
TAKT_NUMBER(current_a, 10, 0, 100, "A",
            "Current of the running motor; heats the winding by 1.5 K/A^2 in the steady state.");
TAKT_NUMBER(trip_k, 90, 1, 1000, "K", "Temperature above ambient that switches the motor off.");
TAKT_NUMBER(clear_k, 60, 0.1, 1000, "K",
            "Temperature above ambient that switches the motor on again; below trip_k.");

namespace {

constexpr double kCheck = 100e-6;  // s between two calls: the basic period of deploy/module.xml

emergency::Drive drive;
int errors = 0;

}  // namespace

extern "C" {

int condition() {
  if (drive.condition(kCheck))
    return TRUE;  // condition is met.
  else
    return FALSE;  // otherwise
}

void initialize(irp::Property const&) {
  drive.current = current_a;
  drive.limit.trip = trip_k;
  drive.limit.clear = clear_k;
  if (!(drive.limit.clear < drive.limit.trip))
    throw std::invalid_argument("property 'clear_k' must be below 'trip_k'");
}

void start(void) { drive.winding.temperature = 0; }

void run(void) { drive.react(); }

void error(int) { ++errors; }

void recover(void) {
  drive.winding.temperature = 0;
  drive.limit.tripped = false;
}

void destruct(void) {
  std::fprintf(stderr,
               "emergency: tripped %llu times, at most %.2f K above ambient, limit %.2f K; %d errors\n",
               static_cast<unsigned long long>(drive.trips), drive.hottest, drive.limit.trip, errors);
}
}
