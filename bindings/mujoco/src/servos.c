/* The memory of the servos of a simulation. */
#include "servos.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int servos_words(const struct servo_config *config)
{
    size_t size = actuator_state_size(&config->settings);
    return SERVO_HEADER + (int)((size + sizeof(mjtNum) - 1) / sizeof(mjtNum));
}

int servos_reset(const mjModel *m, int instance, mjtNum *state, struct actuator_why *why)
{
    struct servo_config config;
    if (!servo_configure(m, instance, &config, why))
        return 0;
    struct actuator *actuator = malloc(actuator_size(&config.settings));
    int words = servos_words(&config), is_done = actuator != NULL;
    for (int i = 0; is_done && i < servo_count(m, instance); i++, state += words) {
        is_done = servo_start(&config, i, actuator, why);
        memset(state, 0, (size_t)words * sizeof *state);
        if (is_done)
            actuator_save(actuator, servo_saved(state), actuator_state_size(&config.settings));
    }
    free(actuator);
    return is_done;
}

/* The list of all servos, without content. */
static struct servos *make_list(const mjModel *m)
{
    size_t count = 0, nv = (size_t)m->nv;
    for (int i = 0; i < m->nplugin; i++)
        count += servo_is(m, i) ? (size_t)servo_count(m, i) : 0;
    struct servos *all = calloc(1, sizeof *all);
    if (!all)
        return NULL;
    all->servo = calloc(count, sizeof *all->servo);
    all->joints = calloc(count, sizeof *all->joints);
    all->memory = calloc(coupling_memory(nv, count), sizeof *all->memory);
    if (all->servo && all->joints && all->memory)
        return all;
    free(all->servo);
    free(all->joints);
    free(all->memory);
    free(all);
    return NULL;
}

/* Adds the servos of an instance to the list. */
static int fill(const mjModel *m, const struct servo_config *config, int instance,
                const struct instance *mine, struct actuator_why *why)
{
    for (int i = 0; i < mine->count; i++) {
        struct servo *servo = mine->all->servo + mine->first + i;
        if (!servo_find(m, instance, i, &servo->place, why))
            return 0;
        servo->input = config->input;
        servo->is_loaded = config->is_loaded;
        servo->scale = config->scale;
        servo->stiffness = config->stiffness;
        servo->inverse_gear = 1.0 / servo->place.gear;
        servo->address = m->plugin_stateadr[instance] + i * servos_words(config);
        servo->size = actuator_state_size(&config->settings);
        servo->actuator = malloc(actuator_size(&config->settings));
        if (!servo->actuator || !servo_start(config, i, servo->actuator, why))
            return 0;
        mine->all->joints[mine->first + i].dof = servo->place.dof;
    }
    return 1;
}

/* Whether the servos are all degrees of freedom, each once, and none is loaded. */
static int moves_all(const mjModel *m, const struct servos *all)
{
    if (all->count != m->nv)
        return 0;
    for (int i = 0; i < all->count; i++) {
        if (all->servo[i].is_loaded)
            return 0;
        for (int j = 0; j < i; j++) {
            if (all->servo[i].place.dof == all->servo[j].place.dof)
                return 0;
        }
    }
    return 1;
}

int servos_create(const mjModel *m, mjData *d, int instance, struct actuator_why *why)
{
    struct servo_config config;
    struct servo_place place;
    /* There is at least one. */
    if (!servo_find(m, instance, 0, &place, why))
        return 0;
    struct instance *mine = calloc(1, sizeof *mine);
    if (!mine)
        return 0;
    d->plugin_data[instance] = (uintptr_t)mine;
    int first = 0;
    while (!servo_is(m, first))
        first++;
    mine->is_owner = first == instance;
    mine->all = mine->is_owner ? make_list(m) : instance_of(d, first)->all;
    mine->count = servo_count(m, instance);
    if (!mine->all)
        return 0;
    mine->first = mine->all->count;
    mine->all->count += mine->count;
    if (!servo_configure(m, instance, &config, why) || !fill(m, &config, instance, mine, why))
        return 0;
    /* The last instance finds all of them. */
    mine->all->moves_all = moves_all(m, mine->all);
    return servos_reset(m, instance, d->plugin_state + m->plugin_stateadr[instance], why);
}

void servos_destroy(mjData *d, int instance)
{
    struct instance *mine = instance_of(d, instance);
    if (!mine)
        return;
    if (mine->is_owner && mine->all) {
        for (int i = 0; i < mine->all->count; i++)
            free(mine->all->servo[i].actuator);
        free(mine->all->servo);
        free(mine->all->joints);
        free(mine->all->memory);
        free(mine->all);
    }
    free(mine);
    d->plugin_data[instance] = 0;
}
