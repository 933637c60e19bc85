/* The decoder on Vulkan. See run_vulkan.h. No object is destroyed, because the process ends afterwards.
 *
 * SPDX-License-Identifier: MIT
 */
#include "run_vulkan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

enum { GROUP = 64 };

typedef struct device {
    VkPhysicalDevice physical;
    VkDevice logical;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    VkSampler sampler;
    VkDescriptorPool descriptors;
    VkDescriptorSetLayout layouts[2]; /* textures; the buffer of records */
    VkDescriptorSet sets[2];
} device;

static void check(VkResult result, const char *step) {
    if (result != VK_SUCCESS) {
        fprintf(stderr, "vulkan: %s: error %d\n", step, (int)result);
        exit(4);
    }
}

static void skip(const char *why) {
    fprintf(stderr, "skipped: vulkan: %s\n", why);
    exit(77);
}

static void open_device(device *d) {
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_0};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pApplicationInfo = &application};
    VkInstance instance;
    VkPhysicalDeviceProperties properties;
    uint32_t count = 1;
    if (vkCreateInstance(&info, NULL, &instance) != VK_SUCCESS) {
        skip("no instance");
    }
    if (vkEnumeratePhysicalDevices(instance, &count, &d->physical) < 0 || count == 0) {
        skip("no device");
    }
    VkQueueFamilyProperties families[8];
    uint32_t family_count = 8;
    vkGetPhysicalDeviceQueueFamilyProperties(d->physical, &family_count, families);
    while (d->family < family_count && !(families[d->family].queueFlags & VK_QUEUE_COMPUTE_BIT)) {
        d->family++;
    }
    if (d->family == family_count) {
        skip("no queue that computes");
    }
    vkGetPhysicalDeviceProperties(d->physical, &properties);
    printf("%s\n", properties.deviceName);
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = d->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo logical = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                        .queueCreateInfoCount = 1,
                                        .pQueueCreateInfos = &queue};
    check(vkCreateDevice(d->physical, &logical, NULL, &d->logical), "device");
    vkGetDeviceQueue(d->logical, d->family, 0, &d->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = d->family};
    check(vkCreateCommandPool(d->logical, &pool, NULL, &d->pool), "command pool");
    const VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    check(vkCreateSampler(d->logical, &sampler, NULL, &d->sampler), "sampler");
}

static VkDeviceMemory allocate(const device *d, VkMemoryRequirements need, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties have;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    vkGetPhysicalDeviceMemoryProperties(d->physical, &have);
    for (uint32_t i = 0; i < have.memoryTypeCount && !memory; i++) {
        if (need.memoryTypeBits >> i & 1 && (have.memoryTypes[i].propertyFlags & flags) == flags) {
            const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                               .allocationSize = need.size,
                                               .memoryTypeIndex = i};
            check(vkAllocateMemory(d->logical, &info, NULL, &memory), "memory");
        }
    }
    check(memory ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY, "memory of that kind");
    return memory;
}

/* Makes a buffer that the CPU can read and write. */
static VkBuffer make_buffer(const device *d, size_t size, VkBufferUsageFlags usage, void **out_data) {
    VkBuffer made;
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VkMemoryRequirements need;
    check(vkCreateBuffer(d->logical, &info, NULL, &made), "buffer");
    vkGetBufferMemoryRequirements(d->logical, made, &need);
    const VkDeviceMemory memory =
        allocate(d, need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(d->logical, made, memory, 0), "buffer memory");
    check(vkMapMemory(d->logical, memory, 0, VK_WHOLE_SIZE, 0, out_data), "mapping");
    return made;
}

static VkCommandBuffer begin(const device *d) {
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = d->pool,
                                              .commandBufferCount = 1};
    const VkCommandBufferBeginInfo start = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check(vkAllocateCommandBuffers(d->logical, &info, &commands), "command buffer");
    check(vkBeginCommandBuffer(commands, &start), "command buffer");
    return commands;
}

static void submit(const device *d, VkCommandBuffer commands) {
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    check(vkEndCommandBuffer(commands), "command buffer");
    check(vkQueueSubmit(d->queue, 1, &info, VK_NULL_HANDLE), "submission");
    check(vkQueueWaitIdle(d->queue), "waiting");
}

static void move_image(VkCommandBuffer commands, VkImage image, VkImageSubresourceRange range,
                       VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                          .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                          .dstAccessMask =
                                              VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                                          .oldLayout = from,
                                          .newLayout = to,
                                          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .image = image,
                                          .subresourceRange = range};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         0, 0, NULL, 0, NULL, 1, &barrier);
}

static VkImageView upload(const device *d, const exported_texture *t) {
    VkImage image;
    VkImageView view;
    VkMemoryRequirements need;
    VkBufferImageCopy regions[LOADED_LEVELS];
    size_t size = 0;
    for (uint32_t i = 0; i < t->data.levels; i++) {
        const uint32_t w = t->data.width >> i, h = t->data.height >> i;
        regions[i] =
            (VkBufferImageCopy){.bufferOffset = size,
                                .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, i, 0, t->data.layers},
                                .imageExtent = {w ? w : 1, h ? h : 1, 1}};
        size += (t->data.size[i] + 15) & ~(size_t)15; /* a multiple of every texel's size */
    }
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = (VkFormat)t->vulkan,
                                    .extent = {t->data.width, t->data.height, 1},
                                    .mipLevels = t->data.levels,
                                    .arrayLayers = t->data.layers,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    const VkImageSubresourceRange range = {VK_IMAGE_ASPECT_COLOR_BIT, 0, t->data.levels, 0, t->data.layers};
    check(vkCreateImage(d->logical, &info, NULL, &image), "image");
    vkGetImageMemoryRequirements(d->logical, image, &need);
    check(vkBindImageMemory(d->logical, image, allocate(d, need, 0), 0), "image memory");
    void *staging;
    const VkBuffer buffer = make_buffer(d, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, &staging);
    for (uint32_t i = 0; i < t->data.levels; i++) {
        memcpy((char *)staging + regions[i].bufferOffset, t->data.data[i], t->data.size[i]);
    }
    const VkCommandBuffer commands = begin(d);
    move_image(commands, image, range, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, t->data.levels,
                           regions);
    move_image(commands, image, range, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    submit(d, commands);
    const VkImageViewCreateInfo view_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                             .image = image,
                                             .viewType = t->is_array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                                     : VK_IMAGE_VIEW_TYPE_2D,
                                             .format = info.format,
                                             .subresourceRange = range};
    check(vkCreateImageView(d->logical, &view_info, NULL, &view), "image view");
    return view;
}

/* Set 0: the textures where the manifest binds them; set 1: the records at binding 0. HLSL has textures without
 * samplers. */
static void make_sets(device *d, const exported *e, VkBuffer records) {
    VkDescriptorSetLayoutBinding bindings[BTF_TEXTURE_COUNT];
    const VkDescriptorType type = !strcmp(e->language, "hlsl") ? VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE
                                                               : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    for (int i = 0; i < e->texture_count; i++) {
        if (e->textures[i].set != 0) {
            skip("a set other than 0");
        }
        bindings[i] = (VkDescriptorSetLayoutBinding){e->textures[i].binding, type, 1,
                                                     VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    }
    const VkDescriptorSetLayoutBinding buffer = {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
                                                 VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    const VkDescriptorSetLayoutCreateInfo infos[2] = {
        {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, NULL, 0, (uint32_t)e->texture_count,
         bindings},
        {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, NULL, 0, 1, &buffer}};
    for (int i = 0; i < 2; i++) {
        check(vkCreateDescriptorSetLayout(d->logical, &infos[i], NULL, &d->layouts[i]), "set layout");
    }
    const VkDescriptorPoolSize sizes[2] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1},
                                           {type, BTF_TEXTURE_COUNT}};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 2,
                                             .poolSizeCount = 2,
                                             .pPoolSizes = sizes};
    check(vkCreateDescriptorPool(d->logical, &pool, NULL, &d->descriptors), "descriptor pool");
    const VkDescriptorSetAllocateInfo sets = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                              .descriptorPool = d->descriptors,
                                              .descriptorSetCount = 2,
                                              .pSetLayouts = d->layouts};
    check(vkAllocateDescriptorSets(d->logical, &sets, d->sets), "descriptor sets");
    for (int i = 0; i < e->texture_count; i++) {
        const VkDescriptorImageInfo info = {d->sampler, upload(d, &e->textures[i]),
                                            VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
        const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = d->sets[0],
                                            .dstBinding = e->textures[i].binding,
                                            .descriptorCount = 1,
                                            .descriptorType = type,
                                            .pImageInfo = &info};
        vkUpdateDescriptorSets(d->logical, 1, &write, 0, NULL);
    }
    const VkDescriptorBufferInfo info = {records, 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = d->sets[1],
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                        .pBufferInfo = &info};
    vkUpdateDescriptorSets(d->logical, 1, &write, 0, NULL);
}

void run_vulkan(const exported *e, const uint32_t *code, size_t code_size, uint32_t *records,
                size_t count) {
    device d = {.family = 0};
    const size_t bytes = count * RECORD * sizeof *records;
    void *mapped;
    open_device(&d);
    const VkBuffer buffer = make_buffer(&d, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, &mapped);
    memcpy(mapped, records, bytes);
    make_sets(&d, e, buffer);
    VkShaderModule module;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    const VkShaderModuleCreateInfo shader = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code_size, .pCode = code};
    check(vkCreateShaderModule(d.logical, &shader, NULL, &module), "SPIR-V");
    const VkPipelineLayoutCreateInfo layout_info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                    .setLayoutCount = 2,
                                                    .pSetLayouts = d.layouts};
    check(vkCreatePipelineLayout(d.logical, &layout_info, NULL, &layout), "pipeline layout");
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = layout};
    check(vkCreateComputePipelines(d.logical, VK_NULL_HANDLE, 1, &info, NULL, &pipeline), "pipeline");
    const VkCommandBuffer commands = begin(&d);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 2, d.sets, 0, NULL);
    vkCmdDispatch(commands, (uint32_t)count / GROUP, 1, 1);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                         &barrier, 0, NULL, 0, NULL);
    submit(&d, commands);
    memcpy(records, mapped, bytes);
}
