// The paper's Figure 8, with one line of user code where the paper prints "...".
#include <takt/module.h>

static int counter = 0;
static int errors = 0;

// clang-format off
extern "C" {
    void initialize(irp::Property const& property) {
        counter = property.get("counter", 5); //user program for initialize() method
    }
    void start(void) {
        errors = 0; //user program for start() method
    }
    void run(void) {
        ++counter; //user program for run() method
    }
    void error(int type) {
        errors += type == TAKT_ERROR_FAILURE; //user program for error() method
    }
    void destruct(void) {
        counter = 0; //user program for destruct() method
    }
    void recover(void) {
        if (errors > 3) takt_fail("too often"); //user program for recover() method
    }
}
